//! Rules on modular devices.

use super::rules;

rules! {
    "eds";

    /// NrOfEntries is not the number of modules
    ///
    /// A tool offers the number of modules that SupportedModules gives.
    ///
    /// # What to do
    ///
    /// Write the number of described modules.
    COUNT: Warning Count, "eds/module/count", "CiA 306" Unknown;

    /// a section of a module is missing
    ///
    /// Modules need the section SupportedModules, and each module has a section such as M1ModuleInfo.
    ///
    /// # What to do
    ///
    /// Add the section.
    SECTION: Warning MissingSection, "eds/module/section-missing", "CiA 306" Unknown;

    /// the numbers of the modules do not start at 1, or have a gap
    ///
    /// A tool looks for the modules 1 to NrOfEntries, and misses the modules after a gap.
    ///
    /// # What to do
    ///
    /// Number the modules from 1 without a gap.
    NUMBER: Warning Count, "eds/module/number", "CiA 306" Unknown;

    /// a module lacks the number of sub-indexes that it adds
    ///
    /// Count is the number of sub-indexes that each module of this kind adds to an object.
    ///
    /// # What to do
    ///
    /// Add Count.
    EXTENSION: Error Number, "eds/module/extension-count", "CiA 306" Unknown;
}
