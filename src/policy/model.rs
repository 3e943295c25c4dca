//! A policy read from its file and prepared to run.

use super::check;
use super::graph::{OUTPUT, operator_sets};
use super::metadata::Metadata;
use super::native::NativeNetwork;
use super::ports::{Input, MaskKind, Part, Ports, Real};
use crate::decision::observation::Layout;
use crate::error::{Error, Result, shown};
use crate::files::folder_of;
use crate::nn::Workspace;
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use tract_onnx::pb::{GraphProto, ModelProto};
use tract_onnx::prelude::{
    Datum, Framework, InferenceFact, InferenceModelExt, IntoRunnable, IntoTValue, TValue, TVec,
    Tensor, TractResult, TypedRunnableModel, TypedSimpleState, f16, tvec,
};

/// The built-in policy.
const SHIPPED: &[u8] = include_bytes!("../../policies/pickline.onnx");

/// A network that turns an observation and a mask into logits.
#[derive(Clone)]
pub struct Policy {
    layout: Layout,
    metadata: Metadata,
    place: String,
    /// Rows that the network takes at once: 1, unless the file fixes another number.
    rows: usize,
    /// The meaning of each input of the network.
    inputs: Vec<Input>,
    /// Index of the output with the logits.
    output: usize,
    /// A remark about that choice, if there are several outputs.
    remark: Option<String>,
    engine: Engine,
}

/// What runs the network.
#[derive(Clone)]
enum Engine {
    /// The code that trained it.
    Native(Arc<NativeNetwork>),
    Tract(Arc<TypedRunnableModel>),
}

impl fmt::Debug for Policy {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Policy")
            .field("place", &self.place)
            .field("layout", &self.layout)
            .finish_non_exhaustive()
    }
}

impl Policy {
    /// The policy in the file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read or is not a policy; the message says what was expected.
    pub fn load(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|source| Error::read(path, source))?;
        let place = path.display().to_string();
        Self::from_model(check::read(&bytes, Some(folder_of(path)), &place)?, &place)
    }

    /// The built-in policy; `policies/README.md` describes how it was trained.
    ///
    /// # Errors
    /// Never for the built-in file; reading it returns a `Result`.
    pub fn shipped() -> Result<Self> {
        Self::from_bytes(SHIPPED, "policies/pickline.onnx")
    }

    /// The policy in `bytes`; `place` is its name in messages.
    ///
    /// # Errors
    /// As for [`Policy::load`], and weights in another file.
    pub fn from_bytes(bytes: &[u8], place: &str) -> Result<Self> {
        Self::from_model(check::read(bytes, None, place)?, place)
    }

    fn from_model(model: ModelProto, place: &str) -> Result<Self> {
        let entries = model.metadata_props.iter();
        let entries = entries.map(|entry| (entry.key.as_str(), entry.value.as_str()));
        let metadata = Metadata::from_file(entries);
        let told = metadata.layout(place)?;
        let graph = model.graph.clone().unwrap_or_default();
        let ports = Ports::find(&graph, told, place)?;
        let layouts = ports.layouts.clone();
        let first = Self::with_ports(&model, &graph, metadata.clone(), ports, place);
        // If the file leaves the outputs' sizes dynamic, a run shows which layout it is.
        let mut others = layouts.into_iter().skip(1);
        let other = first.is_err().then(|| {
            others.find_map(|layout| {
                let ports = Ports::find(&graph, Some(layout), place).ok()?;
                Self::with_ports(&model, &graph, metadata.clone(), ports, place).ok()
            })
        });
        other.flatten().map_or(first, Ok)
    }

    fn with_ports(
        model: &ModelProto,
        graph: &GraphProto,
        metadata: Metadata,
        ports: Ports,
        place: &str,
    ) -> Result<Self> {
        let ours = || NativeNetwork::read(graph, &ports.layout);
        let standard = model.opset_import == operator_sets() && model.functions.is_empty();
        let native = standard.then(ours).flatten();
        let engine = match native {
            Some(network) => Engine::Native(Arc::new(network)),
            None => Engine::Tract(in_tract(model, &ports, place)?),
        };
        let mut policy = Self {
            layout: ports.layout,
            metadata,
            place: place.to_owned(),
            rows: ports.rows,
            inputs: ports.inputs.iter().map(|input| input.kind).collect(),
            output: 0,
            remark: None,
            engine,
        };
        policy.find_output(graph)?;
        Ok(policy)
    }

    /// Runs a network in tract once to find the output with one number per action; one of ours has no other.
    fn find_output(&mut self, graph: &GraphProto) -> Result<()> {
        let observation = vec![0.0; self.layout.observation()];
        let mask = vec![true; self.layout.actions()];
        let Engine::Tract(plan) = &self.engine else {
            return Ok(());
        };
        let mut state = plan.spawn().map_err(|error| self.failed(&error))?;
        let outputs = self.run(&mut state, &observation, &mask)?;
        let actions = self.layout.actions();
        let fits = |value: &TValue| value.len() == self.rows * actions && is_real(value);
        let names: Vec<&str> = graph.output.iter().map(|o| o.name.as_str()).collect();
        let fitting: Vec<usize> = (0..outputs.len().min(names.len()))
            .filter(|&place| fits(&outputs[place]))
            .collect();
        let listed = |places: &mut dyn Iterator<Item = usize>| {
            let quoted = places.map(|place| format!("`{}`", shown(names[place])));
            quoted.collect::<Vec<_>>().join(", ")
        };
        let Some(place) = named_for_logits(&names, &fitting) else {
            return Err(match fitting.len() {
                0 => Error::input(
                    &self.place,
                    format!("no output has {actions} real numbers, one for each action"),
                    "export the network so that it returns the logits of the actions, as f32, \
                     f64 or f16",
                ),
                _ => Error::input(
                    &self.place,
                    format!(
                        "any of the outputs {} could be the logits",
                        listed(&mut fitting.iter().copied())
                    ),
                    format!("name the logits' output `{OUTPUT}` when exporting"),
                ),
            });
        };
        self.output = place;
        self.remark = (names.len() > 1).then(|| {
            let (file, all) = (&self.place, listed(&mut (0..names.len())));
            let taken = shown(names[place]);
            format!("{file}: of the outputs {all}, `{taken}` is used as the logits")
        });
        Ok(())
    }

    /// How to encode the observation.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// What the file says about its observation and its training.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// A remark about how the file was read, if there is one.
    pub fn remark(&self) -> Option<&str> {
        self.remark.as_deref()
    }

    /// The state needed to run it, one per thread.
    ///
    /// # Errors
    /// Never for a loaded policy; tract returns a `Result`.
    pub fn state(&self) -> Result<PolicyState> {
        let state = match &self.engine {
            Engine::Native(network) => EngineState::Native(network.clone(), Box::default()),
            Engine::Tract(plan) => {
                EngineState::Tract(plan.spawn().map_err(|error| self.failed(&error))?)
            }
        };
        Ok(PolicyState {
            policy: self.clone(),
            state,
        })
    }

    /// Runs a network in tract.
    fn run(
        &self,
        state: &mut TypedSimpleState,
        observation: &[f32],
        mask: &[bool],
    ) -> Result<TVec<TValue>> {
        let rows = self.rows;
        let mut inputs: TVec<TValue> = tvec!();
        for input in &self.inputs {
            let tensor = match input {
                Input::Observation(part, real) => {
                    let globals = self.layout.globals();
                    let numbers = match part {
                        Part::Whole => observation,
                        Part::Globals => &observation[..globals],
                        Part::Slots => &observation[globals..],
                    };
                    reals(numbers, *real, rows)
                }
                Input::Mask(MaskKind::Bool) => repeated(mask, rows),
                Input::Mask(MaskKind::Real(real)) => {
                    let mask: Vec<f32> = mask.iter().map(|m| f32::from(u8::from(*m))).collect();
                    reals(&mask, *real, rows)
                }
                Input::Mask(MaskKind::Int64) => {
                    let mask: Vec<i64> = mask.iter().map(|m| i64::from(*m)).collect();
                    repeated(&mask, rows)
                }
            };
            inputs.push(tensor.map_err(|error| self.failed(&error))?.into_tvalue());
        }
        state.run(inputs).map_err(|error| self.failed(&error))
    }

    fn failed(&self, error: &dyn fmt::Display) -> Error {
        Error::input(
            &self.place,
            format!("the network fails: {}", shown(&format!("{error:#}"))),
            "give a policy for one observation at a time, or for a dynamic batch",
        )
    }
}

/// A policy with the buffers needed to run it.
#[derive(Debug)]
pub struct PolicyState {
    policy: Policy,
    state: EngineState,
}

#[derive(Debug)]
enum EngineState {
    Native(Arc<NativeNetwork>, Box<Workspace>),
    Tract(TypedSimpleState),
}

impl PolicyState {
    /// Writes the logits [actions] of one observation.
    ///
    /// # Errors
    /// Never for a loaded policy; tract returns a `Result`.
    pub fn logits(&mut self, observation: &[f32], mask: &[bool], to: &mut [f32]) -> Result<()> {
        let outputs = match &mut self.state {
            EngineState::Native(network, work) => {
                network.logits(observation, mask, work, to);
                return Ok(());
            }
            EngineState::Tract(state) => self.policy.run(state, observation, mask)?,
        };
        let values = real_numbers(&outputs[self.policy.output]);
        let values = values.map_err(|error| self.policy.failed(&error))?;
        let mut values = values.into_iter().take(to.len()).collect::<Vec<f64>>();
        fit_single(&mut values, mask);
        let values: Vec<f32> = values.into_iter().map(|value| value as f32).collect();
        to.copy_from_slice(&values[..to.len()]);
        Ok(())
    }
}

/// Whether a network's output has a type suitable for logits.
fn is_real(value: &TValue) -> bool {
    [f32::datum_type(), f64::datum_type(), f16::datum_type()].contains(&value.datum_type())
}

fn real_numbers(value: &TValue) -> TractResult<Vec<f64>> {
    let value = value.cast_to::<f64>()?;
    Ok(value.try_as_plain_ram()?.as_slice::<f64>()?.to_vec())
}

/// Shifts finite logits that exceed single precision so that the largest allowed one is 0.
/// Order and probabilities are preserved; a cast would make them infinite.
fn fit_single(logits: &mut [f64], mask: &[bool]) {
    let most = f64::from(f32::MAX);
    if !logits.iter().any(|v| v.is_finite() && v.abs() > most) {
        return;
    }
    let allowed = logits.iter().zip(mask).filter(|(_, allowed)| **allowed);
    let highest = allowed.fold(f64::NEG_INFINITY, |high, (value, _)| high.max(*value));
    if !highest.is_finite() {
        return;
    }
    for value in logits.iter_mut().filter(|value| value.is_finite()) {
        *value = (*value - highest).clamp(-most, most);
    }
}

/// Which of the outputs of matching size is named like logits: the only one, or the only one
/// with the most specific name.
fn named_for_logits(names: &[&str], fitting: &[usize]) -> Option<usize> {
    if let [place] = fitting {
        return Some(*place);
    }
    let lower = |place: usize| names[place].to_lowercase();
    let is_other = |name: &str| {
        let other = ["mask", "std", "sigma", "var", "value"];
        other.iter().any(|word| name.contains(word))
    };
    let telling: [fn(&str) -> bool; 3] = [
        |name| name == OUTPUT,
        |name| name.contains("logit"),
        |name| name.contains("action") || name.contains("policy") || name == "pi",
    ];
    telling.iter().find_map(|tells| {
        let mut named = fitting
            .iter()
            .copied()
            .filter(|&place| tells(&lower(place)) && !is_other(&lower(place)));
        named.next().filter(|_| named.next().is_none())
    })
}

/// Like [`repeated`], in the type that the network takes.
fn reals(row: &[f32], real: Real, rows: usize) -> TractResult<Tensor> {
    match real {
        Real::Single => repeated(row, rows),
        Real::Double => {
            let row: Vec<f64> = row.iter().map(|value| f64::from(*value)).collect();
            repeated(&row, rows)
        }
    }
}

/// `row`, repeated as often as the network needs rows.
fn repeated<T: Datum + Copy>(row: &[T], rows: usize) -> TractResult<Tensor> {
    if rows == 1 {
        Tensor::from_shape(&[1, row.len()], row)
    } else {
        Tensor::from_shape(&[rows, row.len()], &row.repeat(rows))
    }
}

/// The network of `model`, prepared by tract.
fn in_tract(model: &ModelProto, ports: &Ports, place: &str) -> Result<Arc<TypedRunnableModel>> {
    let build = || build(model, ports).map_err(|error| format!("{error:#}"));
    // tract does not validate its input in places that our checks do not cover.
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(build))
        .unwrap_or_else(|_| Err("tract panicked".into()))
        .map_err(|error| {
            Error::input(
                place,
                format!("the network cannot be run: {}", shown(&error)),
                "give a policy that uses standard operators, operator set 9 to 20",
            )
        })
}

fn build(model: &ModelProto, ports: &Ports) -> TractResult<Arc<TypedRunnableModel>> {
    // torch's exporters write sizes of intermediate values that contradict a fixed batch.
    let framework = tract_onnx::onnx().with_ignore_value_info(true);
    let framework = framework.with_ignore_output_shapes(true);
    let mut network = framework.model_for_proto_model(model)?;
    for (place, port) in ports.inputs.iter().enumerate() {
        let kind = match port.kind {
            Input::Observation(_, Real::Single) | Input::Mask(MaskKind::Real(Real::Single)) => {
                f32::datum_type()
            }
            Input::Observation(_, Real::Double) | Input::Mask(MaskKind::Real(Real::Double)) => {
                f64::datum_type()
            }
            Input::Mask(MaskKind::Bool) => bool::datum_type(),
            Input::Mask(MaskKind::Int64) => i64::datum_type(),
        };
        let fact = InferenceFact::dt_shape(kind, tvec!(ports.rows, port.width));
        network.set_input_fact(place, fact)?;
    }
    network.into_optimized()?.into_runnable()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Otherwise every decision would take several times as long.
    #[test]
    fn the_shipped_policy_runs_as_it_was_trained() {
        let policy = Policy::shipped().unwrap();
        assert!(matches!(policy.engine, Engine::Native(_)));
    }
}
