//! Rules on modular devices.

use super::rules;

rules! {
    "eds";

    /// NrOfEntries is not the number of modules
    ///
    /// A tool offers as many modules as SupportedModules says.
    ///
    /// # What to do
    ///
    /// Write the number of modules that are described.
    COUNT: Warning Count, "eds/module/count", "CiA 306" Unknown;

    /// a section of a module is missing
    ///
    /// Modules need SupportedModules, and each has a section such as M1ModuleInfo.
    ///
    /// # What to do
    ///
    /// Add the section.
    SECTION: Warning MissingSection, "eds/module/section-missing", "CiA 306" Unknown;

    /// modules are not numbered from 1 without a gap
    ///
    /// A tool looks for modules from 1 to NrOfEntries, and misses those after a gap.
    ///
    /// # What to do
    ///
    /// Number the modules from 1.
    NUMBER: Warning Count, "eds/module/number", "CiA 306" Unknown;

    /// a module does not say how many sub-indexes it adds
    ///
    /// Count tells how many sub-indexes each such module adds to an object.
    ///
    /// # What to do
    ///
    /// Add Count.
    EXTENSION: Error Number, "eds/module/extension-count", "CiA 306" Unknown;
}
