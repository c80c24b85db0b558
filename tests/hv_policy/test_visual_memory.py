import torch

from hv_policy.visual_memory import VisualMemory

CPU = torch.device("cpu")


def frame(step: int, envs: int) -> torch.Tensor:
    return torch.tensor([[100.0 * env + step] for env in range(envs)])


def test_recalls_every_stride_th_frame_oldest_first():
    memory = VisualMemory(frames=2, stride=3)
    for step in range(10):
        recalled, exists = memory.recall(["go"], 1, CPU)
        expected = [step - 6, step - 3]
        assert exists[0].tolist() == [e >= 0 for e in expected]
        assert [r for r, e in zip(recalled[0, :, 0].tolist(), exists[0].tolist(), strict=True) if e] == [
            e for e in expected if e >= 0
        ]
        memory.store(frame(step, 1))


def test_a_new_instruction_empties_only_that_environment():
    memory = VisualMemory(frames=1, stride=2)
    instructions = ["first", "first", "first"]
    for step in range(6):
        if step == 4:
            instructions[1] = "second"
        recalled, exists = memory.recall(instructions, 1, CPU)
        memory.store(frame(step, 3))
        if step >= 4:
            assert exists[:, 0].tolist() == [True, False, True]
            assert recalled[[0, 2], 0, 0].tolist() == [step - 2.0, 200.0 + step - 2]
    recalled, exists = memory.recall(instructions, 1, CPU)
    assert exists.all()  # two steps into the second instruction
    assert recalled[1, 0].item() == 104


def test_another_number_of_environments_empties_everything():
    memory = VisualMemory(frames=1, stride=1)
    memory.recall(["a", "b"], 1, CPU)
    memory.store(frame(0, 2))
    _, exists = memory.recall(["a", "b", "a"], 1, CPU)
    assert not exists.any()
    memory.store(frame(1, 3))
    assert memory.recall(["a", "b", "a"], 1, CPU)[1].all()


def test_clear_forgets():
    memory = VisualMemory(frames=1, stride=1)
    memory.recall(["a"], 1, CPU)
    memory.store(frame(0, 1))
    memory.clear()
    assert not memory.recall(["a"], 1, CPU)[1].any()


def test_no_frames_is_no_memory():
    memory = VisualMemory(frames=0, stride=1)
    recalled, exists = memory.recall(["a", "b"], 4, CPU)
    memory.store(torch.zeros(2, 4))
    assert recalled.shape == (2, 0, 4)
    assert exists.shape == (2, 0)
