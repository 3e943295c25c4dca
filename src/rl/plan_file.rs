//! Plans as files: the differences from a preset, as JSON.
//!
//! A file has the keys of [`Plan`], as in `plan` in a training record. Missing keys have the
//! preset's values. A whole training record is accepted as well.

use super::imitation::Imitation;
use super::plan::{PRESETS, Plan};
use crate::error::{Error, Result, known_names, shown};
use serde_json::Value;

impl Plan {
    /// Reads a plan from `text`, starting from the preset that it names, or else from the first
    /// one. `place` is the file's name in errors.
    ///
    /// # Errors
    /// Not a JSON object, unknown keys, values of the wrong type, an unknown preset, or an
    /// invalid plan.
    pub fn from_file(text: &str, place: &str) -> Result<Self> {
        let file: Value = serde_json::from_str(text).map_err(|error| {
            let cure = "give a JSON object with keys of a plan, or a training record";
            Error::input(place, error.to_string(), cure).caused_by(error)
        })?;
        let asked = match file.get("plan") {
            Some(plan) => plan,
            None => &file,
        };
        let preset = match asked.get("preset") {
            Some(Value::String(name)) => name,
            _ => PRESETS[0].0,
        };
        let plan = Self::preset(preset).map_err(|error| error.inside(place).into_input())?;
        let mut value = serde_json::to_value(plan).unwrap_or_default();
        if asked
            .get("imitation")
            .is_some_and(|imitation| !imitation.is_null())
        {
            value["imitation"] =
                serde_json::to_value(Imitation::of("lookahead")).unwrap_or_default();
        }
        merge(&mut value, asked, "", place)?;
        let plan: Self = serde_json::from_value(value).map_err(|error| {
            let cure = "give every key as in a training record";
            Error::input(place, error.to_string(), cure).caused_by(error)
        })?;
        plan.check()
            .map_err(|error| error.inside(place).into_input())?;
        Ok(plan)
    }
}

/// Overwrites `value` with `asked`, key by key. `path` is the path of both in the plan.
fn merge(value: &mut Value, asked: &Value, path: &str, place: &str) -> Result<()> {
    let wrong = |problem: String, cure: String| Err(Error::input(place, problem, cure));
    match (&mut *value, asked) {
        // Another kind of network has other keys.
        (Value::Object(old), Value::Object(new))
            if new.contains_key("kind") && new.get("kind") != old.get("kind") =>
        {
            *value = asked.clone();
            Ok(())
        }
        (Value::Object(old), Value::Object(new)) => {
            for (key, part) in new {
                let names: Vec<&str> = old.keys().map(String::as_str).collect();
                if !old.contains_key(key) {
                    let problem = format!("unknown key `{path}{}`", shown(key));
                    return wrong(problem, known_names(key, &names));
                }
                merge(&mut old[key], part, &format!("{path}{key}."), place)?;
            }
            Ok(())
        }
        (old, new) if accepts(old, new, path) => {
            *value = new.clone();
            Ok(())
        }
        // Asked to remove what the preset has.
        (_, Value::Null) if path == "imitation." => {
            *value = Value::Null;
            Ok(())
        }
        (old, new) => {
            let name = match path.trim_end_matches('.') {
                "" => "the plan".to_owned(),
                path => format!("`{path}`"),
            };
            // Long enough for any number, short enough for a line.
            let new: String = new.to_string().chars().take(40).collect();
            let cure = match old {
                Value::Object(_) => "give an object, {...}".to_owned(),
                Value::Null if path == SOURCE => {
                    "give a set such as \"balanced\", or null for none".to_owned()
                }
                Value::Null => "give a number, or null for none".to_owned(),
                old => format!("give a value like {old}"),
            };
            wrong(format!("{name} is {new}"), cure)
        }
    }
}

/// The only list that may have any length: the widths of layers.
const LAYERS: &str = "architecture.hidden.";
/// The only key that is missing in every preset and not a number.
const SOURCE: &str = "domain.patterns.";

/// Whether `new` may take the place of `old` at `path`.
fn accepts(old: &Value, new: &Value, path: &str) -> bool {
    match path {
        SOURCE => new.is_string() || new.is_null(),
        _ => fits(old, new) && (path == LAYERS || length(old) == length(new)),
    }
}

/// Number of entries of a list; 0 for anything else.
fn length(value: &Value) -> usize {
    value.as_array().map_or(0, Vec::len)
}

/// Whether `new` has the type of `old`.
fn fits(old: &Value, new: &Value) -> bool {
    match (old, new) {
        // Missing in every preset.
        (Value::Null, Value::Number(_) | Value::Null) => true,
        (Value::Number(old), Value::Number(new)) => !old.is_u64() || new.is_u64(),
        (Value::Array(old), Value::Array(new)) => {
            let like = old.first().unwrap_or(&Value::Null);
            new.iter().all(|part| fits(like, part))
        }
        _ => std::mem::discriminant(old) == std::mem::discriminant(new),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Plan> {
        Plan::from_file(text, "plan.json")
    }

    #[test]
    fn a_file_changes_what_it_names_and_nothing_else() {
        let plan = read(
            r#"{"wait": true, "reward": {"pick": 1}, "ppo": {"target_kl": 0.02},
                "architecture": {"kind": "mlp", "hidden": [8], "activation": "tanh"}}"#,
        )
        .unwrap();
        let mut expected = Plan::preset("default").unwrap();
        expected.wait = true;
        expected.reward.pick = 1.0;
        expected.ppo.target_kl = Some(0.02);
        expected.architecture = Plan::preset("paper").unwrap().architecture;
        match &mut expected.architecture {
            crate::nn::Architecture::Mlp { hidden, .. } => *hidden = vec![8],
            other => panic!("{other:?}"),
        }
        assert_eq!(plan, expected);
        let set = r#"{"domain": {"patterns": "balanced", "items": [50, 50], "curriculum": 0}}"#;
        let expected = Plan::preset("default").unwrap();
        let domain = expected.domain.clone().with_items((50, 50));
        let domain = domain
            .with_curriculum(0.0)
            .with_patterns("balanced".to_owned());
        assert_eq!(read(set).unwrap(), expected.with_domain(domain));
        let plan = read(r#"{"preset": "paper", "imitation": {"rounds": 3}}"#).unwrap();
        assert_eq!((plan.view.as_str(), plan.slots), ("paper", 10));
        assert_eq!(plan.imitation.unwrap().rounds, 3);
    }

    #[test]
    fn every_plan_is_read_as_it_is_written_also_within_a_record() {
        for (name, _) in crate::rl::PRESETS {
            let mut plan = Plan::preset(name).unwrap();
            plan.imitation = Some(Imitation::of("FIFO"));
            plan.ppo.target_kl = Some(0.5);
            plan.domain = plan.domain.with_items((9, 9)).with_curriculum(0.0);
            plan.domain.patterns = Some("poisson:0.2:7".into());
            let text = serde_json::to_string(&plan).unwrap();
            assert_eq!(read(&text).unwrap(), plan);
            let record = format!(r#"{{"seed": 1, "plan": {text}}}"#);
            assert_eq!(read(&record).unwrap(), plan);
        }
    }

    #[test]
    fn slips_name_the_key() {
        for (text, word) in [
            ("[]", "the plan is []"),
            (r#"{"reward": null}"#, "`reward` is null"),
            (r#"{"domain": {"items": [25]}}"#, "`domain.items` is [25]"),
            (r#"{"ppo": {"target_kl": "x"}}"#, "or null for none"),
            ("{", "plan.json"),
            (r#"{"wiat": true}"#, "did you mean `wait`"),
            (r#"{"ppo": {"gama": 1}}"#, "ppo.gama"),
            (r#"{"ppo": {"gamma": "1"}}"#, "`ppo.gamma` is"),
            (r#"{"ppo": {"n_envs": 1.5}}"#, "`ppo.n_envs` is 1.5"),
            (r#"{"ppo": {"n_envs": 1000000000000000000}}"#, "samples"),
            (r#"{"ppo": {"gamma": 1.5}}"#, "ppo.gamma"),
            (
                r#"{"domain": {"spacing": [0.1]}}"#,
                "`domain.spacing` is [0.1]",
            ),
            (r#"{"domain": {"spacing": [0.4, 0.1]}}"#, "domain.spacing"),
            (r#"{"domain": {"items": [0, 5]}}"#, "domain.items"),
            (r#"{"domain": {"update_hz": -1}}"#, "domain.update_hz"),
            (r#"{"domain": {"patterns": 3}}"#, "give a set such as"),
            (
                r#"{"domain": {"patterns": "poisson:x"}}"#,
                "domain.patterns: 'patterns' poisson:x",
            ),
            (
                r#"{"domain": {"patterns": "Cargo.toml"}}"#,
                "`Cargo.toml` is read from files",
            ),
            (
                r#"{"domain": {"patterns": "profile:x.csv"}}"#,
                "`profile:x.csv` is read from files",
            ),
            (
                r#"{"domain": {"patterns": "balanced", "curriculum": 0}}"#,
                "domain.items",
            ),
            (
                r#"{"domain": {"patterns": "balanced", "items": [9, 9]}}"#,
                "domain.curriculum",
            ),
            (r#"{"preset": "papr"}"#, "did you mean `paper`"),
            (r#"{"view": "ful"}"#, "ful"),
            (r#"{"slots": 0}"#, "slots"),
            (r#"{"architecture": {"width": 0}}"#, "1 to 4096"),
            (r#"{"architecture": {"kind": "mpl"}}"#, "plan.json"),
            (r#"{"imitation": {"epochs": 0}}"#, "imitation.epochs"),
            (r#"{"keep": "lst"}"#, "expected `best` or `last`"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
