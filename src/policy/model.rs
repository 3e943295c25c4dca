//! A policy read from its file and made ready to run.

use super::check;
use super::graph::OUTPUT;
use super::metadata::Metadata;
use crate::decision::observation::{Layout, View};
use crate::error::{Error, Result, shown};
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use tract_onnx::pb::{GraphProto, ModelProto, tensor_proto::DataType};
use tract_onnx::prelude::{
    Datum, Framework, InferenceFact, InferenceModelExt, IntoRunnable, IntoTValue, TValue, TVec,
    Tensor, TractResult, TypedRunnableModel, TypedSimpleState, tvec,
};

/// The policy that ships with the program.
const SHIPPED: &[u8] = include_bytes!("../../policies/pickline.onnx");

/// A network that turns an observation and a mask into logits.
#[derive(Clone)]
pub struct Policy {
    layout: Layout,
    metadata: Metadata,
    place: String,
    /// Rows that the network takes at once: 1, or what the file fixes.
    rows: usize,
    /// What each input of the network is.
    inputs: Vec<Input>,
    /// Which of its outputs the logits are.
    output: usize,
    plan: Arc<TypedRunnableModel>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Input {
    Observation,
    /// With the type that the file gives it.
    Mask(MaskKind),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum MaskKind {
    Bool,
    Float,
    Int64,
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
    /// A file that cannot be read or is no policy, saying what was expected.
    pub fn load(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|source| Error::read(path, source))?;
        Self::from_bytes(&bytes, &path.display().to_string())
    }

    /// The policy that ships with the program; `policies/README.md` says how it was
    /// trained.
    ///
    /// # Errors
    /// Never for the file that ships; passed on from reading it.
    pub fn shipped() -> Result<Self> {
        Self::from_bytes(SHIPPED, "policies/pickline.onnx")
    }

    /// The policy in `bytes`; `place` is what messages call it.
    ///
    /// # Errors
    /// As for [`Policy::load`].
    pub fn from_bytes(bytes: &[u8], place: &str) -> Result<Self> {
        let model = check::read(bytes, place)?;
        let entries = model.metadata_props.iter();
        let entries = entries.map(|entry| (entry.key.as_str(), entry.value.as_str()));
        let metadata = Metadata::from_file(entries);
        let told = metadata.layout(place)?;
        let graph = model.graph.clone().unwrap_or_default();
        let ports = Ports::find(&graph, told, place)?;
        let build = || build(&model, &ports).map_err(|error| format!("{error:#}"));
        // tract trusts its input in places that our checks do not reach.
        let plan = std::panic::catch_unwind(std::panic::AssertUnwindSafe(build))
            .unwrap_or_else(|_| Err("tract gave up on it".into()))
            .map_err(|error| {
                Error::input(
                    place,
                    format!("the network cannot be run: {}", shown(&error)),
                    "give a policy of standard operators, operator set 9 to 20",
                )
            })?;
        let mut policy = Self {
            layout: ports.layout,
            metadata,
            place: place.to_owned(),
            rows: ports.rows,
            inputs: ports.inputs.iter().map(|input| input.kind).collect(),
            output: 0,
            plan,
        };
        policy.find_output(&graph)?;
        Ok(policy)
    }

    /// Runs the network once to see which output has a number for every action.
    fn find_output(&mut self, graph: &GraphProto) -> Result<()> {
        let observation = vec![0.0; self.layout.observation()];
        let mask = vec![true; self.layout.actions()];
        let mut state = self.state()?;
        let outputs = state.run(&observation, &mask)?;
        let fits = |value: &TValue| value.len() == self.rows * self.layout.actions();
        let named = graph.output.iter().position(|output| output.name == OUTPUT);
        let found = named.filter(|place| outputs.get(*place).is_some_and(fits));
        match found.or_else(|| outputs.iter().position(fits)) {
            Some(place) => {
                self.output = place;
                Ok(())
            }
            None => Err(Error::input(
                &self.place,
                format!(
                    "no output has {} numbers, one for each action",
                    self.layout.actions()
                ),
                "export the network so that it returns the logits of the actions",
            )),
        }
    }

    /// How to encode what it sees.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// What the file says about itself.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// A state to run it in, for one thread.
    ///
    /// # Errors
    /// Never for a policy that was loaded; passed on from tract.
    pub fn state(&self) -> Result<PolicyState> {
        let state = self.plan.spawn().map_err(|error| self.failed(&error))?;
        Ok(PolicyState {
            policy: self.clone(),
            state,
        })
    }

    fn failed(&self, error: &dyn fmt::Display) -> Error {
        Error::input(
            &self.place,
            format!("the network fails: {}", shown(&format!("{error:#}"))),
            "give a policy for one observation at a time, or of a dynamic batch",
        )
    }
}

/// A policy with the buffers that running it takes.
#[derive(Debug)]
pub struct PolicyState {
    policy: Policy,
    state: TypedSimpleState,
}

impl PolicyState {
    /// Writes the logits [actions] of one observation.
    ///
    /// # Errors
    /// Never for a policy that was loaded; passed on from tract.
    pub fn logits(&mut self, observation: &[f32], mask: &[bool], to: &mut [f32]) -> Result<()> {
        let outputs = self.run(observation, mask)?;
        let view = outputs[self.policy.output].try_as_plain_ram();
        let values = view.and_then(|view| view.as_slice::<f32>().map(<[f32]>::to_vec));
        let values = values.map_err(|error| self.policy.failed(&error))?;
        to.copy_from_slice(&values[..to.len()]);
        Ok(())
    }

    fn run(&mut self, observation: &[f32], mask: &[bool]) -> Result<TVec<TValue>> {
        let rows = self.policy.rows;
        let mut inputs: TVec<TValue> = tvec!();
        for input in &self.policy.inputs {
            let tensor = match input {
                Input::Observation => repeated(observation, rows),
                Input::Mask(MaskKind::Bool) => repeated(mask, rows),
                Input::Mask(MaskKind::Float) => {
                    let mask: Vec<f32> = mask.iter().map(|m| f32::from(u8::from(*m))).collect();
                    repeated(&mask, rows)
                }
                Input::Mask(MaskKind::Int64) => {
                    let mask: Vec<i64> = mask.iter().map(|m| i64::from(*m)).collect();
                    repeated(&mask, rows)
                }
            };
            inputs.push(
                tensor
                    .map_err(|error| self.policy.failed(&error))?
                    .into_tvalue(),
            );
        }
        self.state
            .run(inputs)
            .map_err(|error| self.policy.failed(&error))
    }
}

/// `row` as often as the network wants rows.
fn repeated<T: Datum + Copy>(row: &[T], rows: usize) -> TractResult<Tensor> {
    if rows == 1 {
        Tensor::from_shape(&[1, row.len()], row)
    } else {
        Tensor::from_shape(&[rows, row.len()], &row.repeat(rows))
    }
}

/// The network's inputs, and the layout that they mean.
struct Ports {
    layout: Layout,
    rows: usize,
    inputs: Vec<Port>,
}

struct Port {
    kind: Input,
    width: usize,
}

impl Ports {
    fn find(graph: &GraphProto, told: Option<Layout>, place: &str) -> Result<Self> {
        let wrong = |problem: String, cure: String| Error::input(place, problem, cure);
        let mut found = Vec::new();
        let mut rows = 1;
        for (index, value) in check::inputs(graph) {
            let name = shown(&value.name);
            let Some((dims, kind)) = check::shape(value) else {
                return Err(wrong(
                    format!("the input `{name}` is no tensor of a known shape"),
                    "declare its shape [batch, numbers]".into(),
                ));
            };
            let [batch, Some(width)] = dims[..] else {
                return Err(wrong(
                    format!("the input `{name}` has the shape {dims:?}"),
                    "give it the shape [batch, numbers], the second one fixed".into(),
                ));
            };
            rows = batch.unwrap_or(rows);
            let is_mask =
                value.name.contains("mask") || (index > 0 && kind != DataType::Float as i32);
            let kind = match (is_mask, DataType::try_from(kind)) {
                (false, Ok(DataType::Float)) => Input::Observation,
                (true, Ok(DataType::Bool)) => Input::Mask(MaskKind::Bool),
                (true, Ok(DataType::Float)) => Input::Mask(MaskKind::Float),
                (true, Ok(DataType::Int64)) => Input::Mask(MaskKind::Int64),
                _ => {
                    return Err(wrong(
                        format!("the input `{name}` has a type that is not known here"),
                        "use f32 for observations and bool, f32 or int64 for masks".into(),
                    ));
                }
            };
            found.push(Port { kind, width });
        }
        let width_of = |mask: bool| {
            let is_mask = |port: &&Port| (port.kind != Input::Observation) == mask;
            let mut ports = found.iter().filter(is_mask).map(|port| port.width);
            (ports.next(), ports.next())
        };
        let ((Some(observation), None), (mask, None)) = (width_of(false), width_of(true)) else {
            return Err(wrong(
                format!("the network has {} inputs", found.len()),
                "give one for the observation and at most one for the mask, named with `mask`"
                    .into(),
            ));
        };
        let outputs = graph.output.iter().filter_map(check::shape);
        let outputs: Vec<usize> = outputs.filter_map(|(dims, _)| *dims.last()?).collect();
        let layout = match told {
            Some(layout) => layout,
            None => layout_of(observation, mask, &outputs).ok_or_else(|| {
                wrong(
                    format!(
                        "an input of {observation} numbers with outputs of {outputs:?} is no \
                         observation that this program makes"
                    ),
                    format!(
                        "train on one of: {}; outputs are the logits of K slots, and one more \
                         with waiting",
                        View::ALL.map(written).join(", ")
                    ),
                )
            })?,
        };
        let expected = (layout.observation(), layout.actions());
        if (observation, mask.unwrap_or(expected.1)) != expected {
            return Err(wrong(
                format!(
                    "the network takes {observation} numbers and a mask of {}, its metadata \
                     stands for {} and {}",
                    mask.unwrap_or(expected.1),
                    expected.0,
                    expected.1
                ),
                "export it again with `pickline train`".into(),
            ));
        }
        Ok(Self {
            layout,
            rows,
            inputs: found,
        })
    }
}

/// The size of a view's observation, for messages.
fn written(view: View) -> String {
    let layout = Layout {
        view,
        slots: 1,
        wait: false,
    };
    format!(
        "{view} ({} + {} K)",
        layout.globals(),
        layout.slot_features()
    )
}

/// The layout whose sizes these are, when the file does not say.
fn layout_of(observation: usize, mask: Option<usize>, outputs: &[usize]) -> Option<Layout> {
    let all = View::ALL.into_iter().flat_map(|view| {
        [false, true].map(|wait| Layout {
            view,
            slots: 1,
            wait,
        })
    });
    let sized = all.filter_map(|layout| {
        let slots = observation.checked_sub(layout.globals())?;
        let per_slot = layout.slot_features();
        (slots % per_slot == 0 && (1..=Layout::MOST_SLOTS).contains(&(slots / per_slot))).then_some(
            Layout {
                slots: slots / per_slot,
                ..layout
            },
        )
    });
    // An exporter may leave the sizes of the outputs open.
    let mut fitting = sized.filter(|layout| {
        let actions = layout.actions();
        mask.is_none_or(|mask| mask == actions)
            && (outputs.is_empty() || outputs.contains(&actions))
    });
    fitting.next()
}

fn build(model: &ModelProto, ports: &Ports) -> TractResult<Arc<TypedRunnableModel>> {
    // torch's exporters write sizes of values in between that a fixed batch contradicts.
    let framework = tract_onnx::onnx().with_ignore_value_info(true);
    let framework = framework.with_ignore_output_shapes(true);
    let mut network = framework.model_for_proto_model(model)?;
    for (place, port) in ports.inputs.iter().enumerate() {
        let kind = match port.kind {
            Input::Observation | Input::Mask(MaskKind::Float) => f32::datum_type(),
            Input::Mask(MaskKind::Bool) => bool::datum_type(),
            Input::Mask(MaskKind::Int64) => i64::datum_type(),
        };
        let fact = InferenceFact::dt_shape(kind, tvec!(ports.rows, port.width));
        network.set_input_fact(place, fact)?;
    }
    network.into_optimized()?.into_runnable()
}
