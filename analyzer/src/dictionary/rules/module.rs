//! Modular devices.

use super::rules;

rules! {
    /// NrOfEntries is not the number of modules
    ///
    /// A tool offers as many modules as SupportedModules says.
    ///
    /// # What to do
    ///
    /// Write the number of modules that are described.
    COUNT: Warning Count, "eds/module/count", "CiA 306" Unknown,
        fails "[SupportedModules]\nNrOfEntries=2\n[M1ModuleInfo]\nProductName=Input",
        passes "[SupportedModules]\nNrOfEntries=1\n[M1ModuleInfo]\nProductName=Input";

    /// a section of a module is missing
    ///
    /// Modules need SupportedModules, and each has a section such as M1ModuleInfo.
    ///
    /// # What to do
    ///
    /// Add the section.
    SECTION: Warning MissingSection, "eds/module/section-missing", "CiA 306" Unknown,
        fails "[M1ModuleInfo]\nProductName=Input",
        passes "[SupportedModules]\nNrOfEntries=1\n[M1ModuleInfo]\nProductName=Input";

    /// modules are not numbered from 1 without a gap
    ///
    /// A tool looks for modules from 1 to NrOfEntries, and misses those after a gap.
    ///
    /// # What to do
    ///
    /// Number the modules from 1.
    NUMBER: Warning Count, "eds/module/number", "CiA 306" Unknown,
        fails "[SupportedModules]\nNrOfEntries=1\n[M3ModuleInfo]\nProductName=Input",
        passes "[SupportedModules]\nNrOfEntries=1\n[M1ModuleInfo]\nProductName=Input";

    /// a module does not say how many sub-indexes it adds
    ///
    /// Count tells how many sub-indexes each such module adds to an object.
    ///
    /// # What to do
    ///
    /// Add Count.
    EXTENSION: Error Number, "eds/module/extension-count", "CiA 306" Unknown,
        fails "[SupportedModules]\nNrOfEntries=1\n[M1ModuleInfo]\nProductName=Input\n[M1SubExt6000]\nParameterName=Inputs\nDataType=0x0005\nAccessType=ro\nPDOMapping=1",
        passes "[SupportedModules]\nNrOfEntries=1\n[M1ModuleInfo]\nProductName=Input\n[M1SubExt6000]\nParameterName=Inputs\nDataType=0x0005\nAccessType=ro\nPDOMapping=1\nCount=2\nObjExtend=0";
}
