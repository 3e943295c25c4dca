//! `pickline pattern describe`.

use crate::args::{DescribeArgs, OutputFormat, StationChoice};
use crate::outputs;
use crate::session::Session;
use crate::settings::load_pattern;
use crate::warnings::warn;
use pickline::error::{Error, Result};
use pickline::pattern::{Pattern, describe};
use pickline::plausible::BELT_SPEED;
use pickline::station::BUILT_INS;
use pickline_report::DescriptionReport;

pub(super) fn run(args: DescribeArgs, session: &Session) -> Result<()> {
    let plan = args.resolve()?;
    let report = DescriptionReport::new(describe(&plan.pattern), plan.belt_speed);
    let text = outputs::rendered(&report.named(plan.name), plan.format, &outputs::WHOLE)?;
    session.print(text.as_bytes())
}

/// A resolved call.
struct DescribePlan {
    pattern: Pattern,
    name: String,
    /// Speed of the belt [m/s], for the flow.
    belt_speed: Option<f64>,
    format: OutputFormat,
}

impl DescribeArgs {
    fn resolve(self) -> Result<DescribePlan> {
        if let Some(speed) = self.belt_speed
            && !(speed > 0.0 && speed.is_finite())
        {
            return Err(Error::usage(
                "--belt-speed",
                format!("{speed} is not a belt speed"),
                "give m/s, above 0",
            ));
        }
        let station = self.station.as_ref().map(|station| {
            let choice = StationChoice {
                station: station.clone(),
                robots: None,
                belt_speed: self.belt_speed,
                strict: self.strict,
            };
            choice.load()
        });
        let belt = station.transpose()?.map(|station| *station.belt());
        let usual = BUILT_INS[0].station(None)?;
        let width = belt.map_or(usual.belt().width, |belt| belt.width);
        let (pattern, name) = load_pattern(self.file.as_deref(), width)?;
        let named = self.file.as_deref().unwrap_or(&name);
        let given = self.belt_speed.filter(|_| self.station.is_none());
        let unlikely = given.and_then(|speed| BELT_SPEED.check("--belt-speed", speed));
        warn(
            self.strict,
            unlikely.into_iter().chain(pattern.warnings(named)),
        )?;
        let speed = belt.map(|belt| belt.speed).or(self.belt_speed);
        Ok(DescribePlan {
            pattern,
            name,
            belt_speed: speed,
            format: self.format,
        })
    }
}
