//! The files of a call of `pickline sweep`, whatever is swept.

use super::args::SweepArgs;
use pickline::error::Result;
use pickline::strategies::policy_file;
use pickline::study::ScoredPatterns;
use pickline_report::VerbReport;

impl SweepArgs {
    /// Checks that what is written is not also read.
    pub(crate) fn check_files<R: VerbReport>(
        &self,
        patterns: &ScoredPatterns,
        saved: Option<&str>,
    ) -> Result<()> {
        let source = patterns.source();
        let files = source.files()?;
        let mut read = vec![self.station.file()];
        read.extend(files.iter().map(|file| ("--patterns", Some(&**file))));
        read.push(("--patterns", source.folder()));
        let strategies = saved.into_iter().chain(self.strategy.iter().map(|s| &**s));
        read.extend(strategies.map(|s| ("--strategy", policy_file(s))));
        self.common
            .check_outputs::<R>("sweep", &read, &self.pictures.files())
    }
}
