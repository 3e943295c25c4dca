//! The result of a search.

use super::provenance::Provenance;
use super::rivals::RivalsReport;
use super::table::{Table, cell, column, fixed, interval, without_empty_columns};
use pickline::dispatch::RULES;
use pickline::optimize::{
    FRONT_RUNNERS, Objective, Optimum, Ranked, Risk, Search, SearchKind, StopReason, Validation,
};
use pickline::stats::Interval;
use serde::Serialize;

/// A search as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
pub struct OptimumReport {
    /// The winner's rules, upstream first.
    pub best: Vec<&'static str>,
    /// Name of the objective.
    pub objective: &'static str,
    /// Unit of the objective.
    pub unit: &'static str,
    /// How values of several patterns are aggregated.
    pub risk: String,
    /// `exhaustive` or `grasp`.
    pub search: &'static str,
    /// Why the search ended.
    pub stop_reason: &'static str,
    /// Assignments in the ranking.
    pub assignments: usize,
    /// Number of patterns.
    pub patterns: usize,
    /// Simulated runs: one assignment on one pattern at one belt speed each.
    pub runs: u64,
    /// Limit on the number of runs; `None` if unlimited.
    pub max_runs: Option<u64>,
    /// What GRASP found, if it ran.
    pub grasp: Option<GraspReport>,
    /// The assignment with the highest aggregate before ties were broken.
    pub leader: Vec<&'static str>,
    /// Number of assignments among which the tie was broken, including the leader.
    pub contenders: usize,
    /// How many of them have a speed limit, and over how many patterns; `None` if ties were
    /// broken without it.
    pub speed_limits_of: Option<(usize, usize)>,
    /// How the intervals were computed.
    pub intervals: String,
    /// All assignments, best first.
    pub ranking: Vec<RankedReport>,
    /// The winner on fresh patterns.
    pub validation: Option<ValidationReport>,
    /// Other strategies compared with it; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beside: Option<RivalsReport>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
}

/// What GRASP found.
#[derive(Debug, Clone, Serialize)]
pub struct GraspReport {
    /// Number of starts that reached a local optimum.
    pub starts: usize,
    /// Number of those that ended in the best assignment.
    pub hits: usize,
    /// Moves made by all local searches.
    pub moves: usize,
    /// Width of the restricted candidate list.
    pub alpha: f64,
    /// The best assignment found.
    pub best: Option<Vec<&'static str>>,
    /// Its aggregate.
    pub value: Option<f64>,
    /// Optimum minus that value, if all assignments were also enumerated.
    pub gap: Option<f64>,
}

/// One line of the ranking.
#[derive(Debug, Clone, Serialize)]
pub struct RankedReport {
    /// The rules, upstream first.
    pub assignment: Vec<&'static str>,
    /// Mean of the objective over the patterns.
    pub mean: f64,
    /// Its aggregate under the chosen risk.
    pub value: f64,
    /// Lower end of the 95 % interval of best minus this one; `None` for a single pattern.
    pub diff_low: Option<f64>,
    /// Upper end of that interval.
    pub diff_high: Option<f64>,
    /// Whether that interval contains 0; for a single pattern, whether both are equal.
    pub tied: bool,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// The objective on the worst pattern.
    pub worst: f64,
    /// Label of the worst pattern.
    pub worst_pattern: String,
    /// Mean speed limit [m/s], if it broke a tie.
    pub max_speed: Option<f64>,
}

/// The winner on patterns that played no part in choosing it.
#[derive(Debug, Clone, Serialize)]
pub struct ValidationReport {
    /// Description of the patterns.
    pub patterns: String,
    /// Number of patterns.
    pub count: usize,
    /// Mean of the objective.
    pub mean: f64,
    /// Lower end of its 95 % interval; `None` for a single pattern.
    pub mean_low: Option<f64>,
    /// Upper end of its 95 % interval.
    pub mean_high: Option<f64>,
    /// The objective aggregated under the risk used in the search.
    pub value: f64,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// The objective on the worst pattern.
    pub worst: f64,
    /// Belt speed at which completion was counted [m/s].
    pub speed: f64,
    /// Number of patterns that were picked completely.
    pub complete: usize,
    /// Their share of the patterns: the task-completion share.
    pub complete_share: f64,
    /// Lower end of its 95 % interval.
    pub complete_low: f64,
    /// Upper end of its 95 % interval.
    pub complete_high: f64,
    /// Its picks compared with the bound for every strategy; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<CertificateReport>,
}

/// Picks compared with the bound for every strategy.
#[derive(Debug, Clone, Serialize)]
pub struct CertificateReport {
    /// Number of patterns with a bound: the first of those above.
    pub patterns: usize,
    /// Upper bound on the share of their items that can be picked.
    pub picked_share: f64,
    /// Picks on these patterns as a proven share of the optimum [%], rounded down.
    pub certified_percent: f64,
}

impl ValidationReport {
    /// The report of `validation` on the patterns described by `patterns`.
    pub fn new(validation: &Validation, patterns: &str) -> Self {
        let (mean_low, mean_high) = Interval::ends(validation.interval);
        Self {
            patterns: patterns.to_owned(),
            count: validation.patterns,
            mean: validation.value,
            mean_low,
            mean_high,
            value: validation.at_risk,
            picked_share: validation.picked_share,
            worst: validation.worst,
            speed: validation.speed,
            complete: validation.complete,
            complete_share: validation.complete_share(),
            complete_low: validation.complete_interval.low,
            complete_high: validation.complete_interval.high,
            bound: validation.certificate.as_ref().map(|c| CertificateReport {
                patterns: c.patterns,
                picked_share: c.picked_share,
                certified_percent: c.percent,
            }),
        }
    }

    fn lines(&self, digits: usize, unit: &str, risk: &str) -> String {
        let at_risk = match risk {
            // Already printed.
            "mean" | "worst" => String::new(),
            _ => format!(", {risk} {}", fixed(self.value, digits)),
        };
        let ends = self.mean_low.zip(self.mean_high);
        let interval = ends.map_or(String::new(), |ends| {
            format!(" (95 % interval {})", interval(Some(ends), digits))
        });
        format!(
            "validated mean {}{unit}{interval}{at_risk}, worst {}, {} % picked\n          \
             task completion at {} m/s: {} of {} patterns fully picked, {} % (95 % interval {} to {} %)\n          \
             on {}\n{}",
            fixed(self.mean, digits),
            fixed(self.worst, digits),
            fixed(100.0 * self.picked_share, 1),
            self.speed,
            self.complete,
            self.count,
            fixed(100.0 * self.complete_share, 1),
            fixed(100.0 * self.complete_low, 1),
            fixed(100.0 * self.complete_high, 1),
            self.patterns,
            self.bound.as_ref().map_or(String::new(), |bound| format!(
                "certified at least {} % of the picks that the best strategy could make (bounded: the first {} of these)\n",
                fixed(bound.certified_percent, 1),
                bound.patterns
            ))
        )
    }
}

impl OptimumReport {
    /// The report of `optimum`; `labels` names the patterns.
    pub fn new(
        optimum: &Optimum,
        search: &Search,
        objective: Objective,
        labels: &[String],
        validation: Option<ValidationReport>,
        notes: Vec<String>,
        made: Provenance,
    ) -> Self {
        let ranking = &optimum.ranking;
        let line = |ranked: &Ranked| {
            let (diff_low, diff_high) = Interval::ends(ranked.difference);
            RankedReport {
                assignment: ranked.assignment.names(),
                mean: ranked.mean,
                value: ranked.value,
                diff_low,
                diff_high,
                tied: ranked.tied,
                picked_share: ranked.picked_share,
                worst: ranked.worst,
                worst_pattern: labels[ranked.worst_pattern].clone(),
                max_speed: ranked.max_speed,
            }
        };
        Self {
            best: ranking.best().assignment.names(),
            objective: objective.name(),
            unit: objective.unit(),
            risk: search.risk.to_string(),
            search: match optimum.kind {
                SearchKind::Grasp => "grasp",
                _ => "exhaustive",
            },
            stop_reason: optimum.stop.name(),
            assignments: ranking.entries.len(),
            patterns: optimum.patterns,
            runs: optimum.runs,
            max_runs: optimum.max_runs,
            grasp: optimum.grasp.as_ref().map(|grasp| GraspReport {
                starts: grasp.starts,
                hits: grasp.hits,
                moves: grasp.moves,
                alpha: search.grasp.alpha,
                best: grasp.best.as_ref().map(|best| best.names()),
                value: grasp.best.as_ref().map(|_| grasp.value),
                gap: optimum.grasp_gap,
            }),
            leader: ranking.leader.names(),
            contenders: ranking.contenders,
            speed_limits_of: ranking.by_speed,
            intervals: ranking.method.clone(),
            ranking: ranking.entries.iter().map(line).collect(),
            validation,
            beside: None,
            notes,
            made,
        }
    }

    /// The unit for a column header; shares have none.
    pub(super) fn bracketed_unit(&self) -> String {
        match self.unit {
            "1" => String::new(),
            unit => format!(" [{unit}]"),
        }
    }

    /// Whether the risk needs a column besides those of mean and worst.
    pub(super) fn has_risk_column(&self) -> bool {
        ![Risk::Mean, Risk::Worst]
            .map(|r| r.to_string())
            .contains(&self.risk)
    }

    /// The unit after a number; shares have none.
    pub(super) fn spaced_unit(&self) -> String {
        match self.unit {
            "1" => String::new(),
            unit => format!(" {unit}"),
        }
    }

    /// The name in CSV files of a figure of the objective: `picking_rate_mean_per_min`.
    pub(super) fn column(&self, figure: &str) -> String {
        let objective = self.objective.replace('-', "_");
        column(&format!("{objective}_{figure}"), self.unit)
    }

    /// Decimals suitable for the objective's unit.
    pub(super) fn digits(&self) -> usize {
        match self.unit {
            "1/min" => 2,
            _ => 4,
        }
    }

    /// The first `top` lines of the ranking and everything about them.
    pub fn to_table(&self, top: usize) -> String {
        let digits = self.digits();
        let unit = self.bracketed_unit();
        let mut header = vec![
            "#".to_owned(),
            "<assignment".to_owned(),
            format!("mean{unit}"),
        ];
        let by_risk = self.has_risk_column();
        if by_risk {
            header.push(format!("{}{unit}", self.risk));
        }
        header.extend([
            "best minus this, 95 %".to_owned(),
            "<".to_owned(),
            "picked [%]".to_owned(),
            format!("worst{unit}"),
            "<on pattern".to_owned(),
        ]);
        let by_speed = self.ranking.iter().any(|line| line.max_speed.is_some());
        if by_speed {
            header.push("max speed [m/s]".to_owned());
        }
        let mut table = Table::new(&header.iter().map(String::as_str).collect::<Vec<_>>());
        for (i, line) in self.ranking.iter().take(top).enumerate() {
            let mut row = vec![
                (i + 1).to_string(),
                bracketed(&line.assignment),
                fixed(line.mean, digits),
            ];
            if by_risk {
                row.push(fixed(line.value, digits));
            }
            row.extend([
                if i == 0 {
                    String::new()
                } else {
                    interval(line.diff_low.zip(line.diff_high), digits)
                },
                (match (i, line.tied) {
                    (0, _) => "best",
                    (_, true) => "tied",
                    (_, false) => "",
                })
                .to_owned(),
                fixed(100.0 * line.picked_share, 1),
                fixed(line.worst, digits),
                line.worst_pattern.clone(),
            ]);
            if by_speed {
                row.push(line.max_speed.map_or(String::new(), |v| fixed(v, 4)));
            }
            table.row(row);
        }
        let mut text = table.render();
        if self.ranking.len() > top {
            text += &format!("          ... {} more (--top)\n", self.ranking.len() - top);
        }
        text += &format!(
            "best      {}: {}, {}\n",
            bracketed(&self.best),
            self.objective,
            self.risk
        );
        text += &self.tie_line();
        text += &self.search_line();
        if let Some(validation) = &self.validation {
            text += &validation.lines(digits, &self.spaced_unit(), &self.risk);
        }
        if let Some(beside) = &self.beside {
            text += &beside.to_table(self);
        }
        for note in &self.notes {
            text += &format!("note      {note}\n");
        }
        text + &self.made.lines()
    }

    /// How ties were broken and how the search went, one sentence each.
    pub(super) fn search_notes(&self) -> Vec<String> {
        // The table's lines begin with a ten-character word; continuation lines are indented to
        // it.
        let sentence = |line: String| {
            let words = line.split_whitespace().collect::<Vec<_>>().join(" ");
            words.replacen(' ', ": ", 1)
        };
        vec![sentence(self.tie_line()), sentence(self.search_line())]
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
            (StopReason::TimeLimit, "ended by --time-limit"),
            (StopReason::Budget, "cut short by its budget of runs"),
        ];
        let cut_short = cut_short
            .iter()
            .find(|(reason, _)| reason.name() == self.stop_reason);
        let how = if let Some((_, how)) = cut_short {
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
                    fixed(gap, self.digits()),
                    self.spaced_unit()
                ),
                _ => String::new(),
            };
            let starts = match grasp.starts {
                0 => "no start was completed".to_owned(),
                starts => format!("{} of {starts} starts ended in its best", grasp.hits),
            };
            format!("; GRASP (alpha {}): {starts}{gap}", grasp.alpha)
        });
        let most = match self.max_runs {
            Some(most) => format!(" of at most {most} (--max-runs)"),
            None => String::new(),
        };
        format!("search    {how}{grasp}; {} runs{most}\n", self.runs)
    }

    /// The whole ranking as CSV.
    pub fn to_csv(&self) -> String {
        let header = vec![
            "rank".into(),
            "assignment".into(),
            self.column("mean"),
            self.column("value"),
            self.column("diff_low"),
            self.column("diff_high"),
            "tied".into(),
            "picked_share".into(),
            self.column("worst"),
            "worst_pattern".into(),
            "max_speed_m_per_s".into(),
        ];
        let rows = self.ranking.iter().enumerate().map(|(i, line)| {
            vec![
                (i + 1).to_string(),
                line.assignment.join(" "),
                line.mean.to_string(),
                line.value.to_string(),
                cell(line.diff_low),
                cell(line.diff_high),
                line.tied.to_string(),
                line.picked_share.to_string(),
                line.worst.to_string(),
                line.worst_pattern.clone(),
                line.max_speed.map(|v| v.to_string()).unwrap_or_default(),
            ]
        });
        let rows = std::iter::once(header).chain(rows);
        self.made.csv(without_empty_columns(rows))
    }
}

pub(super) fn bracketed(names: &[&str]) -> String {
    format!("[{}]", names.join("; "))
}
