import pytest

from hv_sim.grounding import ground
from hv_sim.landmarks import landmarks
from hv_sim.places import layout_at
from hv_sim.suites import load_suite

TASKS = load_suite("seen")[::50]


@pytest.mark.parametrize("task", TASKS, ids=lambda t: t.name)
def test_words_fit_their_landmark_alone(task):
    """The reader of instructions, who knows the words but not who wrote them, understands the same."""
    for subtask in range(len(task.subtasks)):
        layout = layout_at(task, subtask)
        known = landmarks(task, subtask)
        assert len(known) > 10
        asked = task.subtasks[subtask].object
        other = next(o.name for o in task.objects if o.name != asked)
        for landmark in known:
            for phrase in landmark.phrases:
                if landmark.is_spot:
                    meant = ground(f"Move it {phrase}.", layout)
                    assert not meant.objects
                    [goal] = ground(f"Put {_name_of(known, other, asked)} {phrase}.", layout).goals
                    spot = layout.spot_m(goal, asked)
                    assert spot == pytest.approx(landmark.position_m[:2])
                elif landmark.object:
                    assert ground(f"Put {phrase} on the floor.", layout).objects == {landmark.object}
                    assert landmark.position_m == layout.poses[landmark.object][0]


def _name_of(known, *names):
    """Words for one of these objects; those that have none of their own are called box, which the reader takes too."""
    return next((k.phrases[0] for name in names for k in known if k.object == name and k.phrases), "the box")


def test_no_two_landmarks_share_words():
    for task in TASKS:
        phrases = [p for k in landmarks(task, 1) for p in k.phrases]
        assert len(phrases) == len(set(phrases))


def test_after_the_first_sub_task_its_object_is_at_its_goal():
    for task in TASKS:
        first = task.subtasks[0]
        moved = [k for k in landmarks(task, 1) if k.object == first.object]
        assert all(k.position_m == first.goal_position_m for k in moved)
