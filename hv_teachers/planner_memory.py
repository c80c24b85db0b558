"""The scripted planner's memory as the networks', and back."""

from __future__ import annotations

from hv_policy.decision.memory import TaskMemory
from hv_teachers.planner import ScriptedPlanner


def lend_memory(memory: TaskMemory, planner: ScriptedPlanner) -> None:
    """Makes the planner believe that all this happened to it."""
    planner.phase, planner.clock_s = memory.phase.clone(), memory.clock_s.clone()
    planner._from_hands, planner._offset = memory.from_hands.clone(), memory.offset.clone()
    planner._from_object, planner._start_height = memory.from_object_w.clone(), memory.start_height.clone()


def memory_of(planner: ScriptedPlanner) -> TaskMemory:
    """What the planner remembers now."""
    return TaskMemory(
        phase=planner.phase.clone(),
        clock_s=planner.clock_s.clone(),
        from_hands=planner._from_hands.clone(),
        offset=planner._offset.clone(),
        from_object_w=planner._from_object.clone(),
        start_height=planner._start_height.clone(),
    )
