//! Games in Gambit's file format.

use pickline::optimize::game::Game;
use std::fmt::Write as _;

/// `game` in Gambit's strategic game format, payoff version (the .nfg file format of Savani and
/// Turocy, Gambit, <https://www.gambit-project.org>). Payoffs are exact decimals, which Gambit
/// reads as rational numbers. The first player's strategy varies fastest, as the format
/// requires. `comment` names the game's origin.
pub fn nfg_text(game: &Game, title: &str, comment: &str) -> String {
    let players = game.players();
    let names: Vec<String> = players.iter().map(|p| quoted(&p.name)).collect();
    let mut text = format!("NFG 1 R {} {{ {} }}\n\n{{", quoted(title), names.join(" "));
    for player in players {
        let names: Vec<String> = player.actions.iter().map(|a| quoted(a)).collect();
        // Writing to memory cannot fail.
        let _ = write!(text, " {{ {} }}", names.join(" "));
    }
    text += &format!(" }}\n{}\n\n", quoted(comment));
    let mut profile = vec![0; players.len()];
    for _ in 0..game.profiles() {
        let number = (0..players.len()).fold(0, |n, i| n * game.actions(i) + profile[i]);
        let payoffs: Vec<String> = game.payoffs(number).iter().map(|p| p.to_string()).collect();
        text += &payoffs.join(" ");
        text.push('\n');
        for (i, action) in profile.iter_mut().enumerate() {
            *action += 1;
            if *action < game.actions(i) {
                break;
            }
            *action = 0;
        }
    }
    text
}

/// A quoted text. The only escape in Gambit is that of the quote itself, so other troublesome
/// characters are replaced.
fn quoted(text: &str) -> String {
    let plain = |c: char| match c {
        '\\' => '/',
        c if c.is_control() => ' ',
        c => c,
    };
    let text: String = text.chars().map(plain).collect();
    format!("\"{}\"", text.replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pickline::optimize::game::{Payoff, Player};

    #[test]
    fn the_first_player_varies_fastest() {
        let player = |name: &str, actions: &[&str]| Player {
            name: name.into(),
            actions: actions.iter().map(|&a| a.into()).collect(),
        };
        let players = vec![
            player("r\"1\"", &["A", "B"]),
            player("r\\2", &["C", "D", "E"]),
        ];
        let payoffs = (0..12)
            .map(|i| Payoff::rounded(f64::from(i) / 4.0))
            .collect();
        let game = Game::of_payoffs(players, payoffs).unwrap();
        assert_eq!(
            nfg_text(&game, "two", "by\nhand"),
            "NFG 1 R \"two\" { \"r\\\"1\\\"\" \"r/2\" }\n\n\
             { { \"A\" \"B\" } { \"C\" \"D\" \"E\" } }\n\"by hand\"\n\n\
             0 0.25\n1.5 1.75\n0.5 0.75\n2 2.25\n1 1.25\n2.5 2.75\n"
        );
    }
}
