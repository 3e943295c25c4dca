"""Episodes of strategies as Minari datasets: written, loaded, learned from."""

import sys

import gymnasium
import numpy as np
import pytest

import pickline

minari = pytest.importorskip("minari", reason="minari is not installed")

# Minari asks for an author, and for the address of the code.
pytestmark = pytest.mark.filterwarnings("ignore::UserWarning:minari")

SOURCE = "poisson:0.12:8"


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    """Where Minari keeps its datasets."""
    place = tmp_path / "datasets"
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(place))
    return place


def episodes_of(dataset):
    """The episodes, each with its metadata."""
    known = dataset.storage.get_episode_metadata(range(dataset.total_episodes))
    return list(zip(dataset.iterate_episodes(), known, strict=True))


@pytest.mark.parametrize("strategy", ["SPT,FIFO", "onnx"])
def test_the_environment_plays_the_same_episodes(strategy):
    pickline.to_minari("pickline/simple-v0", strategy, patterns=SOURCE, grasp_success=0.8)
    dataset = minari.load_dataset("pickline/simple-v0")
    patterns = pickline.patterns(SOURCE, pickline.Station("paper"))
    assert dataset.total_episodes == len(patterns) == 8
    assert dataset.storage.metadata["left_out"] == 0
    for episode, known in episodes_of(dataset):
        assert known["pattern"] == episode.id
        # What goes wrong with a pattern is a matter of its place among the others.
        env = pickline.SortingEnv("paper", patterns, grasp_success=0.8)
        assert (dataset.observation_space, dataset.action_space.n) == (
            env.observation_space,
            env.action_space.n,
        )
        observation, info = begin_on(env, patterns[known["pattern"]])
        for step in range(len(episode)):
            assert np.array_equal(observation, episode.observations[step])
            assert np.array_equal(info["action_mask"], episode.infos["action_mask"][step])
            action = episode.actions[step]
            observation, reward, terminated, truncated, info = env.step(action)
            assert reward == episode.rewards[step]
            assert (terminated, truncated) == (episode.terminations[step], episode.truncations[step])
        assert terminated and np.array_equal(observation, episode.observations[-1])
        assert not episode.infos["action_mask"][-1].any()
        for figure in ("items", "picked", "weight", "end", "picking_rate", "weighted_rate"):
            assert known[figure] == info[figure], figure


def begin_on(env, pattern):
    """Begins episodes until one is on this pattern."""
    observation, info = env.reset(seed=1)
    while env.patterns[env._batch.picks(0)[0]] != pattern:
        observation, info = env.reset()
    return observation, info


@pytest.mark.parametrize("options", [dict(), dict(wait=True), dict(slots=2), dict(slots=2, wait=True)])
def test_what_is_no_action_is_done_and_counted(options):
    # Each robot's first decision is a wait, and then it takes what came onto the belt last.
    waited = set()

    def patient(seen):
        if seen.robot not in waited:
            waited.add(seen.robot)
            return pickline.Wait()
        return len(seen.item) - 1

    pattern = pickline.Pattern.grid(1.05, 0.15, 30)
    dataset = pickline.to_minari("pickline/patient-v0", patient, "paper", pattern, **options)
    ((episode, known),) = episodes_of(dataset)
    decisions = len(episode) + known["left_out"]
    assert dataset.storage.metadata["decisions"] == decisions
    assert dataset.storage.metadata["left_out"] == known["left_out"]
    waits = decisions - known["picked"]
    assert waits == len(waited) > 0
    waiting = episode.actions == dataset.action_space.n - 1
    if options.get("wait"):
        assert waiting.sum() == waits
    else:
        assert known["left_out"] >= waits
    assert known["left_out"] > waits or "slots" not in options
    assert episode.rewards.sum() == pytest.approx(known["weight"] + known["weighted_rate"])
    allowed = episode.infos["action_mask"][np.arange(len(episode)), episode.actions]
    assert allowed.all()
    assert f"{known['left_out']} of {decisions} decisions are left out" in dataset.storage.metadata["description"]


def test_the_environment_is_recovered():
    options = dict(items=30, pattern_seed=7, observation="paper", wait=True)
    pickline.to_minari(
        "pickline/paper/simple-v2", "SPT,SPT", "paper", SOURCE, author="me", update_hz=10.0, **options
    )
    dataset = minari.load_dataset("pickline/paper/simple-v2")
    assert dataset.storage.metadata["author"] == {"me"}
    assert dataset.storage.metadata["algorithm_name"] == "rules:SPT,SPT"
    env = dataset.recover_environment()
    due = gymnasium.make(
        "pickline/Sorting-v0", station="paper", patterns=SOURCE, update_hz=10.0, **options
    )
    (found, seen), (expected, info) = env.reset(seed=3), due.reset(seed=3)
    assert np.array_equal(found, expected)
    assert np.array_equal(seen["action_mask"], info["action_mask"])
    # The registered environment is as it was.
    assert not gymnasium.spec("pickline/Sorting-v0").kwargs
    # What cannot be written down is not pretended to be known.
    line = pickline.Station("paper")
    dataset = pickline.to_minari("pickline/objects-v0", "SPT,FIFO", line, pickline.patterns(SOURCE, line))
    with pytest.raises((ValueError, AttributeError)):
        dataset.recover_environment()


def boom(seen):
    raise KeyError("boom")


def stop(done, total, what):
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("name", "strategy", "options", "kind", "words"),
    [
        ("no name", "SPT,FIFO", dict(), ValueError, "dataset_id: 'no name' is not the name"),
        ("pickline/x-v0", "SPT,FIFO,LPT", dict(), ValueError, "3"),
        ("pickline/x-v0", boom, dict(), KeyError, "boom"),
        ("pickline/x-v0", "lookahead", dict(progress=stop), KeyboardInterrupt, ""),
        ("pickline/x-v0", "SPT,FIFO", dict(patterns=[]), ValueError, "no pattern"),
        ("pickline/x-v0", "SPT,FIFO", dict(slots=0), ValueError, "slots"),
        ("pickline/x-v0", "SPT,FIFO", dict(reward=(1.0, float("nan"))), ValueError, "rate"),
        ("pickline/x-v0", "SPT,FIFO", dict(colour=1), TypeError, "colour"),
        ("pickline/x-v0", lambda seen: pickline.Wait(), dict(), ValueError, "pattern 0: nothing that"),
        (
            "pickline/x-v0",
            "SPT,FIFO",
            dict(patterns=pickline.Pattern([0.0], [0.5]), station=pickline.Station("paper", robots=1)),
            ValueError,
            "",
        ),
    ],
)
def test_what_is_wrong_leaves_no_dataset(folder, name, strategy, options, kind, words):
    with pytest.raises(kind) as raised:
        pickline.to_minari(name, strategy, **{"patterns": SOURCE} | options)
    assert words in str(raised.value)
    assert not list(folder.rglob("data"))


def test_datasets_are_not_replaced(folder):
    pickline.to_minari("pickline/once-v0", "SPT,FIFO", patterns=SOURCE)
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    with pytest.raises(ValueError, match="there is a dataset 'pickline/once-v0'\n  cure: give another"):
        pickline.to_minari("pickline/once-v0", boom, patterns=SOURCE)
    assert before == {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_a_write_that_fails_leaves_no_dataset(folder, monkeypatch):
    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr("minari.dataset.minari_storage.MinariStorage.update_metadata", full)
    with pytest.raises(OSError, match="no space"):
        pickline.to_minari("pickline/half-v0", "SPT,FIFO", patterns=SOURCE)
    assert not list(folder.rglob("half-v0"))


@pytest.mark.parametrize("package", ["minari", "h5py", "PIL"])
def test_without_a_package(monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=r"cure: pip install 'minari\[hdf5\]' pillow"):
        pickline.to_minari("pickline/x-v0", "SPT,FIFO", patterns=SOURCE)


class Cloned:
    """A score for each slot from its features and the globals, by a small network; the actions of a
    dataset become likely under the softmax of the scores."""

    GLOBALS, FEATURES, HIDDEN = 21, 17, 32

    def __init__(self, rng):
        inputs = self.GLOBALS + self.FEATURES
        self.weights = [rng.normal(0, inputs**-0.5, (inputs, self.HIDDEN)), np.zeros(self.HIDDEN)]
        self.weights.append(rng.normal(0, self.HIDDEN**-0.5, self.HIDDEN))

    def slots(self, observations):
        """What the network sees of each slot [rows, slots, inputs]."""
        rows = len(observations)
        slots = observations[:, self.GLOBALS :].reshape(rows, -1, self.FEATURES)
        line = observations[:, None, : self.GLOBALS]
        return np.concatenate([slots, np.broadcast_to(line, (*slots.shape[:2], self.GLOBALS))], axis=2)

    def probabilities(self, inputs, masks):
        """The hidden layer and the probability of each slot."""
        first, shift, second = self.weights
        hidden = np.tanh(inputs @ first + shift)
        scores = np.where(masks > 0, hidden @ second, -np.inf)
        scores = np.exp(scores - scores.max(axis=1, keepdims=True))
        return hidden, scores / scores.sum(axis=1, keepdims=True)

    def slopes(self, inputs, masks, actions):
        """The derivatives of the mean cross entropy."""
        hidden, wrong = self.probabilities(inputs, masks)
        wrong[np.arange(len(actions)), actions] -= 1.0
        wrong /= len(actions)
        before = wrong[:, :, None] * self.weights[2] * (1.0 - hidden**2)
        flat = inputs.reshape(-1, inputs.shape[2]).T @ before.reshape(-1, self.HIDDEN)
        return flat, before.sum(axis=(0, 1)), np.einsum("rk,rkh->h", wrong, hidden)

    def learn(self, observations, masks, actions, rng, epochs=30, rate=3e-3):
        """Adam on batches of 256."""
        inputs = self.slots(observations)
        means = [np.zeros_like(w) for w in self.weights]
        squares = [np.zeros_like(w) for w in self.weights]
        steps = 0
        for _ in range(epochs):
            for rows in np.array_split(rng.permutation(len(actions)), max(1, len(actions) // 256)):
                steps += 1
                found = self.slopes(inputs[rows], masks[rows], actions[rows])
                for weight, mean, square, slope in zip(self.weights, means, squares, found, strict=True):
                    mean += 0.1 * (slope - mean)
                    square += 0.001 * (slope**2 - square)
                    scale = np.sqrt(square / (1 - 0.999**steps)) + 1e-8
                    weight -= rate * mean / (1 - 0.9**steps) / scale

    def __call__(self, observation, mask):
        """The likeliest action."""
        return self.probabilities(self.slots(observation[None]), mask[None])[1].argmax()


def rate_of(act, patterns):
    """Mean weighted rate [1/min] of a policy over patterns."""
    rates = []
    for pattern in patterns:
        env = pickline.SortingEnv("paper", pattern)
        observation, info = env.reset(seed=1)
        terminated = False
        while not terminated:
            action = act(observation, info["action_mask"])
            observation, _, terminated, _, info = env.step(action)
        rates.append(info["weighted_rate"])
    return np.mean(rates)


def test_an_expert_is_cloned():
    expert = "lookahead:depth=3,bases=SPT+FIFO"
    pickline.to_minari("pickline/expert-v0", expert, patterns="poisson:0.12:60", pattern_seed=1)
    dataset = minari.load_dataset("pickline/expert-v0")
    episodes = list(dataset.iterate_episodes())
    observations = np.concatenate([episode.observations[:-1] for episode in episodes])
    masks = np.concatenate([episode.infos["action_mask"][:-1] for episode in episodes])
    actions = np.concatenate([episode.actions for episode in episodes])
    rng = np.random.default_rng(1)
    cloned = Cloned(rng)
    cloned.learn(observations, masks, actions, rng)
    fresh = pickline.patterns("poisson:0.12:20", pickline.Station("paper"), seed=99)
    by_chance = rate_of(lambda _, mask: rng.choice(np.flatnonzero(mask)), fresh)
    learned = rate_of(cloned, fresh)
    due = np.mean([pickline.simulate("paper", pattern, expert).weighted_rate for pattern in fresh])
    assert by_chance < learned and due - learned < learned - by_chance, (by_chance, learned, due)
