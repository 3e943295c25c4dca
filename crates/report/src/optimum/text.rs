//! A search as text for the terminal.

use super::objective::bracketed;
use super::report::{OptimumReport, RankedReport};
use crate::columns::TableColumns;
use crate::presentation::Presentation;
use crate::table::{fixed, interval};
use pickline::dispatch::RULES;
use pickline::optimize::{FRONT_RUNNERS, Proof, StopReason};

impl OptimumReport {
    /// The first `top` lines of the ranking and everything about them.
    pub(super) fn text(&self, shown: &Presentation) -> String {
        let top = shown.top;
        let digits = self.format().digits();
        let rows = self.ranking.iter().take(top).enumerate();
        let mut text = self.columns().table(rows);
        if self.ranking.len() > top {
            let more = self.ranking.len() - top;
            text += &shown.spelled(&format!("          ... {more} more ('top')\n"));
        }
        text += &format!(
            "best      {}: {}, {}\n",
            bracketed(&self.best),
            self.objective,
            self.risk
        );
        text += &self.tie_line();
        text += &shown.spelled(&self.search_line());
        if let Some(validation) = &self.validation {
            text += &validation.lines(digits, &self.format().spaced_unit(), &self.risk);
        }
        if let Some(beside) = &self.beside {
            text += &{
                let validated = self.validation.as_ref().map(|v| v.patterns.as_str());
                beside.to_table(self.format(), &self.best, validated)
            };
        }
        for note in &self.notes {
            text += &format!("note      {note}\n");
        }
        text + &self.made.lines()
    }

    fn columns(&self) -> TableColumns<'_, (usize, &RankedReport), String> {
        let digits = self.format().digits();
        let unit = self.format().bracketed_unit();
        let by_risk = self.format().has_risk_column();
        let by_speed = self.ranking.iter().any(|line| line.max_speed.is_some());
        TableColumns::new()
            .with("#", |(i, _): &(usize, &RankedReport)| (i + 1).to_string())
            .with("<assignment", |(_, line)| bracketed(&line.assignment))
            .with(format!("mean{unit}"), move |(_, line)| {
                fixed(line.mean, digits)
            })
            .with_if(by_risk, format!("{}{unit}", self.risk), move |(_, line)| {
                fixed(line.value, digits)
            })
            .with("best minus this, 95 %", move |(i, line)| match i {
                0 => String::new(),
                _ => interval(line.difference, digits),
            })
            .with("<", |(i, line)| line.standing(*i).to_owned())
            .with("picked [%]", |(_, line)| {
                fixed(100.0 * line.picked_share, 1)
            })
            .with(format!("worst{unit}"), move |(_, line)| {
                fixed(line.worst, digits)
            })
            .with("<on pattern", |(_, line)| line.worst_pattern.clone())
            .with_if(by_speed, "max speed [m/s]", |(_, line)| {
                line.max_speed.map_or(String::new(), |v| fixed(v, 4))
            })
    }

    /// How ties were broken and how the search went, one sentence each.
    pub(super) fn search_notes(&self, shown: &Presentation) -> Vec<String> {
        // The table's lines begin with a ten-character word; continuation lines are indented to
        // it.
        let sentence = |line: String| {
            let words = line.split_whitespace().collect::<Vec<_>>().join(" ");
            words.replacen(' ', ": ", 1)
        };
        let searched = shown.spelled(&self.search_line());
        vec![sentence(self.tie_line()), sentence(searched)]
    }

    fn tie_line(&self) -> String {
        if self.contenders < 2 {
            return format!("ties      none; {}\n", self.intervals);
        }
        let figure = |names: &[&str]| {
            let line = self.ranking.iter().find(|line| line.assignment == names);
            line.map(|line| line.value)
        };
        let changed = if figure(&self.leader) == figure(&self.best) {
            String::new()
        } else {
            format!(
                "; {} had the highest {}",
                bracketed(&self.leader),
                self.risk
            )
        };
        let tied = self.ranking.iter().filter(|line| line.tied).count();
        let order: Vec<_> = RULES.iter().map(|rule| rule.name()).collect();
        // If the speed limit is the objective, it cannot break ties.
        let by_speed = match self.speed_limits_of {
            Some((of, over)) if (of, over) == (self.contenders, self.patterns) => {
                "max speed, then by ".to_owned()
            }
            Some((of, over)) => {
                format!("max speed (of the {of} of highest mean, over {over} patterns), then by ")
            }
            None => String::new(),
        };
        format!(
            "ties      {tied} tied with the best ({}); it is the first of {} contenders, those that\n          \
             none of the {FRONT_RUNNERS} highest is proven better than, by {by_speed}worst pattern, then by\n          \
             mean, then by the order {}{changed}\n",
            self.intervals,
            self.contenders,
            order.join(" ")
        )
    }

    fn search_line(&self) -> String {
        let cut_short = [
            (StopReason::Interrupted, "interrupted"),
            (StopReason::TimeLimit, "ended by 'until'"),
            (StopReason::Budget, "fitted to its budget of runs"),
        ];
        let cut_short = cut_short
            .iter()
            .find(|(reason, _)| reason.name() == self.stop_reason);
        let how = if self.stop_reason == StopReason::Proven.name() {
            "proven optimal by branch and bound".to_owned()
        } else if let Some((_, how)) = cut_short {
            format!(
                "{how}; {} assignments scored on {} patterns",
                self.assignments, self.patterns
            )
        } else if self.search == "exhaustive" {
            format!("all {} assignments enumerated", self.assignments)
        } else {
            format!("{} assignments scored", self.assignments)
        };
        let grasp = self.grasp.as_ref().map_or(String::new(), |grasp| {
            let gap = match (grasp.gap, &grasp.best) {
                (Some(gap), Some(best)) => format!(
                    ", best {}, gap to the optimum {}{}",
                    bracketed(best),
                    fixed(gap, self.format().digits()),
                    self.format().spaced_unit()
                ),
                _ => String::new(),
            };
            let starts = match grasp.starts {
                0 => "no start was completed".to_owned(),
                starts => format!("{} of {starts} starts came upon its best", grasp.hits),
            };
            format!("; GRASP (alpha {}): {starts}{gap}", grasp.alpha)
        });
        let most = match self.max_runs {
            Some(most) => format!(" of at most {most} ('runs')"),
            None => String::new(),
        };
        let proof = self.proof.as_ref().map(|proof| self.proof_line(proof));
        format!(
            "search    {how}{grasp}; {} runs{most}\n{}",
            self.runs,
            proof.unwrap_or_default()
        )
    }

    fn proof_line(&self, proof: &Proof) -> String {
        let figure = |value| {
            format!(
                "{}{}",
                fixed(value, self.format().digits()),
                self.format().spaced_unit()
            )
        };
        let proven = match proof.gap {
            0.0 => "no assignment scores higher".to_owned(),
            gap => format!(
                "no assignment scores above {}, {} more than {}",
                figure(proof.most),
                figure(gap),
                bracketed(&self.leader)
            ),
        };
        let share = 100.0 * proof.passes as f64 / proof.tree_passes;
        format!(
            "proof     {proven}; {} prefixes followed, {} merged: after GRASP, {} passes of\n          \
             a robot over a pattern, {} % of those of all assignments\n",
            proof.nodes,
            proof.merged,
            proof.passes,
            fixed(share, if share < 1.0 { 3 } else { 0 })
        )
    }
}
