//! A solved game as text for the terminal.

use super::report::{EquilibriumReport, GameReport, RobotRulesReport};
use crate::columns::TableColumns;
use crate::presentation::Presentation;
use crate::table::fixed;
use pickline::error::counted;
use pickline::optimize::game::Payoff;

/// Decimals of rates [1/min].
const DIGITS: usize = 2;
/// Decimals of margins and prices, which are small differences.
const FINE: usize = 4;

impl GameReport {
    /// The first equilibria and cycles, and everything about them.
    pub(super) fn text(&self, shown: &Presentation) -> String {
        let mut text = equilibria(self, shown);
        text.push('\n');
        text += &optimum_lines(self);
        text += &best_response_lines(self, shown);
        text.push('\n');
        text += &rules(self);
        text.push('\n');
        for note in &self.notes {
            text += &format!("note      {note}\n");
        }
        text + &self.made.lines()
    }
}

fn rate(value: Payoff) -> String {
    fixed(value.value(), DIGITS)
}

fn bracketed(names: &[String]) -> String {
    format!("[{}]", names.join("; "))
}

fn equilibria(report: &GameReport, shown: &Presentation) -> String {
    if report.equilibria.is_empty() {
        return format!(
            "no pure equilibrium: from each of the {} assignments some robot gains by changing its \
             rule\n",
            report.profiles.len()
        );
    }
    let optimum = report.social_optimum.welfare.value();
    let mut columns = TableColumns::new()
        .with("#", |(i, _): &(usize, &EquilibriumReport)| {
            (i + 1).to_string()
        })
        .with("<equilibrium", |(_, line)| bracketed(&line.assignment))
        .with("<", |(_, line)| kind(line));
    for (robot, name) in report.robots.iter().enumerate() {
        columns = columns.with(format!("{name} [1/min]"), move |(_, line)| {
            rate(line.rates[robot])
        });
    }
    let columns = columns
        .with("line [1/min]", |(_, line)| rate(line.welfare))
        .with("of optimum [%]", move |(_, line)| match optimum > 0.0 {
            true => fixed(100.0 * line.welfare.value() / optimum, 1),
            false => String::new(),
        })
        .with("least loss [1/min]", |(_, line)| {
            let margin = line.margin_to_others;
            margin.map_or(String::new(), |margin| fixed(margin.value(), FINE))
        })
        .with("proven losses", |(_, line)| {
            line.proven.map_or(String::new(), |proven| {
                let others = line.deviations.iter().filter(|d| !d.equivalent);
                format!("{proven} of {}", others.count())
            })
        })
        .with("reached from", |(_, line)| {
            format!("{} of {}", line.basin, report.profiles.len())
        });
    let lines = report.equilibria.iter().take(shown.top).enumerate();
    let mut text = columns.table(lines);
    if report.equilibria.len() > shown.top {
        let more = report.equilibria.len() - shown.top;
        text += &shown.spelled(&format!("            ... {more} more equilibria ('top')\n"));
    }
    text
}

/// A rule with an equivalent makes any equilibrium weak; this separates that case from real
/// ties.
fn kind(line: &EquilibriumReport) -> String {
    match (line.kind, line.margin_to_others) {
        ("weak", Some(margin)) if margin > Payoff::default() => "strict except for equal rules",
        (kind, _) => kind,
    }
    .to_owned()
}

fn optimum_lines(report: &GameReport) -> String {
    let paid = match report.payoff {
        "own" => "each robot receives its own picks per minute, 60 k_i / T",
        _ => "each robot receives the line's picks per minute, 60 k / T",
    };
    let strict = report.equilibria.iter().filter(|e| e.kind == "strict");
    let best = &report.social_optimum;
    let shown: Vec<String> = best
        .assignments
        .iter()
        .take(3)
        .map(|a| bracketed(a))
        .collect();
    let more = match best.assignments.len() - shown.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let price = |price: Option<f64>| match price {
        Some(price) => fixed(price, FINE),
        None if report.equilibria.is_empty() => "undefined (no pure equilibrium)".to_owned(),
        None => "unbounded (an equilibrium picks nothing)".to_owned(),
    };
    format!(
        "game        {paid}; {}, {} assignments, {}\n\
         equilibria  {} pure, {} of them strict; payoffs are equal when they round to the same \
         {:e} 1/min\n\
         optimum     {} 1/min by {}{more}: {}\n\
         anarchy     price {}: the optimum over the worst equilibrium\n\
         stability   price {}: the optimum over the best equilibrium\n",
        counted(report.robots.len(), "robot"),
        report.profiles.len(),
        match report.patterns {
            1 => "one pattern".to_owned(),
            n => format!("mean over {n} patterns"),
        },
        report.equilibria.len(),
        strict.count(),
        report.resolution,
        rate(best.welfare),
        shown.join(", "),
        if best.is_equilibrium {
            "an equilibrium"
        } else {
            "no equilibrium"
        },
        price(report.price_of_anarchy),
        price(report.price_of_stability),
    )
}

fn best_response_lines(report: &GameReport, shown: &Presentation) -> String {
    let play = &report.best_response;
    let path = |assignments: &[Vec<String>]| {
        let texts: Vec<String> = assignments.iter().map(|a| bracketed(a)).collect();
        texts.join(" > ")
    };
    let mut text = format!(
        "responses   robots in turn, upstream first, change to their best rule: from {} of {} \
         starts to an equilibrium, from {} into a cycle\n\
         longest     {} changes, most rounds {}: {}\n",
        play.to_equilibrium,
        play.starts,
        play.to_cycle,
        play.most_changes,
        play.most_rounds,
        path(&play.longest),
    );
    for cycle in play.cycles.iter().take(shown.top) {
        text += &format!(
            "cycle       {}, from {} starts\n",
            path(&cycle.assignments),
            cycle.basin
        );
    }
    if play.cycles.len() > shown.top {
        let more = play.cycles.len() - shown.top;
        text += &shown.spelled(&format!("            ... {more} more cycles ('top')\n"));
    }
    text
}

/// What every rule is worth to every robot, whatever the others do.
fn rules(report: &GameReport) -> String {
    let robot = |robot: &&RobotRulesReport| robot.robot.clone();
    let columns = report.rules.iter().fold(
        TableColumns::new().with("<robot", robot),
        |columns, rule| {
            columns.with(format!("<{rule}"), move |robot: &&RobotRulesReport| {
                cell(robot, rule)
            })
        },
    );
    columns.table(&report.rules_of_robots)
        + "whatever the others do: < X always worse than rule X; <= X never better, sometimes \
           worse; = X equal; best: never worse than any\n"
}

fn cell(robot: &RobotRulesReport, rule: &String) -> String {
    if let Some(dominated) = robot.dominated.iter().find(|d| d.rule == *rule) {
        let sign = match dominated.how {
            "strictly" => "<",
            _ => "<=",
        };
        return format!("{sign} {}", dominated.by);
    }
    let best = robot.dominant.contains(rule);
    let same = robot.equivalent.iter().find(|group| group.contains(rule));
    let same = same
        .and_then(|group| group.first())
        .filter(|first| *first != rule);
    match (best, same) {
        (true, Some(first)) => format!("best, = {first}"),
        (true, None) => "best".into(),
        (false, Some(first)) => format!("= {first}"),
        (false, None) => String::new(),
    }
}
