"""The vector environment."""

import multiprocessing
import os
import subprocess
import sys
import threading

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import pickline

ID = "pickline/Sorting-v0"
SMALL = {"patterns": "poisson:0.2:5", "items": 12}


def random_actions(masks, rng):
    """One allowed action for each row of masks."""
    return np.where(masks, rng.random(masks.shape), -1.0).argmax(axis=1)


def test_it_is_the_vector_environment_of_gymnasium_to_the_bit():
    ours = gymnasium.make_vec(ID, num_envs=5, **SMALL)
    assert isinstance(ours.unwrapped, pickline.SortingVectorEnv)
    assert ours.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    theirs = SyncVectorEnv(
        [lambda: gymnasium.make(ID, **SMALL)] * 5, autoreset_mode=AutoresetMode.SAME_STEP
    )
    assert ours.observation_space == theirs.observation_space
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.action_space == theirs.action_space
    assert ours.single_action_space == theirs.single_action_space
    rng = np.random.default_rng(1)
    ends = 0
    for seed in (3, [7, 1, 7, 9, 2], None):
        got, want = ours.reset(seed=seed), theirs.reset(seed=seed)
        assert data_equivalence(got, want, exact=True)
        masks = got[1]["action_mask"]
        for _ in range(60):
            actions = random_actions(masks, rng)
            got, want = ours.step(actions), theirs.step(actions)
            # A truncation, if any, is a bool array too.
            assert data_equivalence(got[:4], want[:4], exact=True)
            assert same_infos(got[4], want[4])
            assert got[0] in ours.observation_space
            ends += got[2].sum()
            masks = got[4]["action_mask"]
    assert ends > 5
    ours.close()
    theirs.close()


def same_infos(got, want):
    """Whether infos are equal; None stands where an episode goes on."""
    got, want = dict(got), dict(want)
    ours, theirs = got.pop("final_obs", None), want.pop("final_obs", None)
    if (ours is None) != (theirs is None):
        return False
    if ours is not None:
        for a, b in zip(ours, theirs, strict=True):
            if (a is None) != (b is None) or (a is not None and not np.array_equal(a, b)):
                return False
    return data_equivalence(sort(got), sort(want), exact=True)


def sort(infos):
    """The same dictionary in the order of its keys."""
    return {k: sort(v) if isinstance(v, dict) else v for k, v in sorted(infos.items())}


def test_arrays_are_new_at_every_step_unless_asked_otherwise():
    env = gymnasium.make_vec(ID, num_envs=3, **SMALL)
    first, info = env.reset(seed=1)
    kept = first.copy(), info["action_mask"].copy()
    env.step(np.zeros(3, int))
    assert np.array_equal(first, kept[0]) and np.array_equal(info["action_mask"], kept[1])
    env = gymnasium.make_vec(ID, num_envs=3, copy=False, **SMALL)
    first, _ = env.reset(seed=1)
    assert env.step(np.zeros(3, int))[0] is first


def test_some_environments_can_be_reset():
    env = gymnasium.make_vec(ID, num_envs=3, **SMALL)
    start, _ = env.reset(seed=1)
    moved = env.step(np.zeros(3, int))[0]
    chosen = np.array([False, True, False])
    got, info = env.reset(seed=[None, 2, None], options={"reset_mask": chosen})
    assert np.array_equal(got[1], start[1])
    assert np.array_equal(got[::2], moved[::2])
    assert info["_action_mask"].tolist() == chosen.tolist()
    for mask, kind in [
        (np.zeros(3, bool), ValueError),
        (np.ones(2, bool), ValueError),
        ([True] * 3, TypeError),
    ]:
        with pytest.raises(kind, match="reset_mask"):
            env.reset(options={"reset_mask": mask})


def test_wrong_use_is_an_exception_and_changes_nothing():
    env = gymnasium.make_vec(ID, num_envs=3, **SMALL).unwrapped
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([0, 0, 0])
    observations, info = env.reset(seed=1)
    free = np.flatnonzero(~env.action_masks()[2])[0]
    for actions, kind, words in [
        ([0, 0, free], ValueError, "environment 2: .*\n  cure: choose an action"),
        ([0, -1, 0], ValueError, "environment 1: "),
        ([0, 16, 0], ValueError, "environment 1: "),
        (np.array([0, 0, 2**64 - 1], np.uint64), ValueError, "environment 2: "),
        ([0.0, 0.0, 0.0], TypeError, "float64"),
        ([True, True, True], TypeError, "bool"),
        (["a", "b", "c"], TypeError, "dtype"),
        ([0, 0], ValueError, r"shape \(2,\)"),
        ([[0, 0, 0]], ValueError, r"shape \(1, 3\)"),
        (0, ValueError, r"shape \(\)"),
    ]:
        with pytest.raises(kind, match=words):
            env.step(actions)
        assert np.array_equal(env._observations, observations)
        assert np.array_equal(env._masks, info["action_mask"])
    with pytest.raises(ValueError, match="2 seeds"):
        env.reset(seed=[1, 2])
    with pytest.raises(ValueError, match="unknown option"):
        env.reset(options={"mask": 1})
    # Every second value of an array, which is not contiguous.
    env.step(np.zeros(6, np.int32)[::2])
    env.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        env.step([0, 0, 0])
    with pytest.raises(ValueError, match="num_envs"):
        pickline.SortingVectorEnv(0)


def fingerprint(steps=40, num_envs=40):
    """What comes of random actions, as one number for each step."""
    env = gymnasium.make_vec(ID, num_envs=num_envs, **SMALL)
    _, info = env.reset(seed=5)
    rng = np.random.default_rng(1)
    sums = []
    for _ in range(steps):
        actions = random_actions(info["action_mask"], rng)
        observations, rewards, _, _, info = env.step(actions)
        sums.append((float(observations.sum(dtype=np.float64)), float(rewards.sum())))
    return sums


def test_the_number_of_threads_does_not_matter():
    code = "from test_vector import fingerprint; print(fingerprint())"
    paths = os.path.dirname(__file__) + os.pathsep + os.environ.get("PYTHONPATH", "")
    printed = [
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "RAYON_NUM_THREADS": threads, "PYTHONPATH": paths},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "3")
    ]
    assert printed[0] == printed[1] == f"{fingerprint()}\n"


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_other_processes_step_too(method):
    want = fingerprint()
    with multiprocessing.get_context(method).Pool(2) as pool:
        got = [pool.apply_async(fingerprint) for _ in range(2)]
        assert [result.get(timeout=60) for result in got] == [want, want]


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_an_environment_goes_on_in_a_forked_child():
    env = gymnasium.make_vec(ID, num_envs=40, **SMALL)
    env.reset(seed=1)
    env.step(np.zeros(40, int))
    receiver, sender = multiprocessing.Pipe(duplex=False)

    def child():
        sender.send(env.step(np.zeros(40, int))[0])

    process = multiprocessing.get_context("fork").Process(target=child)
    process.start()
    assert receiver.poll(60)
    assert np.array_equal(receiver.recv(), env.step(np.zeros(40, int))[0])
    process.join(60)
    assert process.exitcode == 0


def test_one_environment_in_many_threads_is_refused_or_right():
    env = gymnasium.make_vec(ID, num_envs=64).unwrapped
    env.reset(seed=1)
    problems = []

    def steps():
        for _ in range(100):
            try:
                env.step(np.zeros(64, int))
            except RuntimeError as error:
                problems.append(str(error))

    threads = [threading.Thread(target=steps) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all("by another thread\n  cure: " in problem for problem in problems)
    env.reset(seed=1)
    env.step(np.zeros(64, int))


def resident():
    """Memory of this process [kB]."""
    with open("/proc/self/status", encoding="utf-8") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_memory_is_flat_over_a_million_steps():
    env = gymnasium.make_vec(ID, num_envs=256, observation="paper", **SMALL)
    _, info = env.reset(seed=1)
    single = gymnasium.make(ID, **SMALL)
    rng = np.random.default_rng(1)
    seen = []
    for step in range(4000):
        actions = random_actions(info["action_mask"], rng)
        _, _, _, _, info = env.step(actions)
        if step % 40 == 0:
            single.reset()
            single.step(0)
        if step % 500 == 499:
            seen.append(resident())
    assert 4000 * 256 > 1_000_000
    # The first eighth warms up.
    assert max(seen[1:]) - seen[0] < 2000, seen
