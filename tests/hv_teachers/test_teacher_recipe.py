"""Configurations and recipes: what each baseline changes, equal budgets, and errors that name the field."""

from pathlib import Path

import pytest

from hv_teachers.curriculum import share_of_tasks
from hv_teachers.teacher_config import CONFIG_FOLDER, TeacherTrainingConfig, plain, read_yaml, training_config
from hv_teachers.teacher_recipe import read_recipe, train_recipe

RECIPES = (
    "humanoidverse_teacher", "humanvla_teacher", "end_to_end", "single_teacher",
    "wo_stage2", "wo_stage3", "wo_speed", "wo_distance", "monolithic",
)  # fmt: skip


def configs(name):
    recipe = read_recipe(name)
    return recipe, {stage: recipe.config(stage, Path("out")) for stage in recipe.stages}


@pytest.mark.parametrize("name", RECIPES)
def test_every_system_has_the_same_budget(name):
    assert read_recipe(name).samples() == read_recipe("humanoidverse_teacher").samples() == 30_000_000
    assert read_recipe(name).about


@pytest.mark.parametrize("stage", [1, 2, 3])
def test_stages(stage):
    config = training_config(read_yaml(f"teacher_stage{stage}"))
    assert (config.env.reward == "retreat") is (stage == 2)
    assert bool(config.first_teacher) is (stage == 3)
    assert bool(config.init) is (stage > 1)
    assert config.env.end_when_placed is (stage == 1), "letting go is Stage 2's"
    assert config.dagger.samples > config.ppo.samples > 0


def test_a_recipe_is_scaled_as_a_whole():
    recipe = read_recipe("humanoidverse_teacher")
    whole, tenth = (recipe.config("stage1", Path("out"), scale=scale) for scale in (1.0, 0.1))
    assert (tenth.dagger.samples, tenth.ppo.samples) == (whole.dagger.samples // 10, whole.ppo.samples // 10)
    assert plain(tenth) | {"dagger": 0, "ppo": 0} == plain(whole) | {"dagger": 0, "ppo": 0}
    assert recipe.samples(scale=0.1) == 3_000_000
    assert recipe.samples("stage2", scale=0.1) == recipe.samples("stage2") // 10
    for scale in (0, -1, "much", True):
        with pytest.raises(ValueError, match=r"scale: .* is not valid; valid: a number > 0"):
            train_recipe(recipe, Path("out"), {"scale": scale})


def test_recipes_do_what_they_say():
    recipe, stages = configs("humanoidverse_teacher")
    assert (recipe.teacher_1, recipe.teacher_2) == ("stage2", "stage3")
    assert stages["stage3"].init == "out/stage1/teacher.safetensors"
    assert stages["stage3"].first_teacher == "out/stage2/teacher.safetensors"
    assert stages["stage3"].env.instructor.max_object_speed_m_s is not None

    recipe, stages = configs("wo_speed")
    assert all(c.env.instructor.max_object_speed_m_s is None for c in stages.values())
    assert all(c.env.instructor.max_object_goal_distance_m is not None for c in stages.values())
    recipe, stages = configs("wo_distance")
    assert all(c.env.instructor.max_object_goal_distance_m is None for c in stages.values())
    assert recipe.instructor.max_object_speed_m_s is not None

    recipe, stages = configs("wo_stage2")
    assert all(c.env.reward == "rearrange" for c in stages.values())
    assert (recipe.teacher_1, recipe.teacher_2) == ("stage1", None)
    assert list(stages) == ["stage1"], "who never lets go never begins a second half"
    recipe, stages = configs("wo_stage3")
    assert recipe.teacher_2 == "stage1"
    assert not any(c.first_teacher for c in stages.values())

    recipe, stages = configs("single_teacher")
    assert (recipe.teacher_1, recipe.teacher_2) == ("stage3", None)
    assert stages["stage3"].init == "out/stage2/teacher.safetensors"
    recipe, stages = configs("humanvla_teacher")
    assert recipe.teacher_2 is None
    assert list(stages) == ["stage1"]
    assert stages["stage1"].part == "first"
    assert stages["stage1"].env.end_when_placed
    recipe, stages = configs("end_to_end")
    assert stages["stage1"].dagger.samples == stages["stage1"].ppo.imitation_batches == 0
    assert stages["stage1"].part == "whole"
    assert stages["stage1"].tasks == "seen"
    assert not stages["stage1"].env.end_when_placed
    recipe, stages = configs("monolithic")
    assert all(
        (c.teacher.action, c.teacher.memory, c.teacher.route) == ("joints", "none", False) for c in stages.values()
    )


def test_overrides_and_their_errors():
    config = training_config({"ppo": {"samples": "2e6"}}, {"env.num_envs": 8, "teacher.hidden": [4, 5]})
    assert (config.ppo.samples, config.env.num_envs, config.teacher.hidden) == (2_000_000, 8, (4, 5))
    assert training_config({"ppo.samples": 1}, plain(config)) == config
    one = {"ppo.samples": 1}
    for values, message in (
        ({"env.threads": 1}, r"env\.threads: unknown; valid: num_envs, "),
        ({"speed": 1}, r"^speed: unknown; valid: name, tasks, "),
        ({"env.num_envs": "many"}, r"env\.num_envs: 'many' is not valid; valid: int"),
        ({"env.num_envs": 1.5}, r"env\.num_envs: 1\.5 is not valid"),
        ({"env": 3}, r"env: 3 is not valid; valid: a mapping"),
        ({"part": "half"}, r"part: 'half' is not valid; valid: whole, single, first"),
        ({"env.instructor.min_steps": None}, r"min_steps: None is not valid"),
        ({"env.task_reward.height": -1}, r"reward\.height: -1"),
    ):
        with pytest.raises(ValueError, match=message):
            training_config(one, values)
    with pytest.raises(ValueError, match=r"dagger\.samples, ppo\.samples: both 0"):
        TeacherTrainingConfig()


def test_bad_recipes(tmp_path):
    def write(text):
        (tmp_path / "r.yaml").write_text(text)
        return str(tmp_path / "r.yaml")

    for text, message in (
        ("stages: {a: {init: b}, b: {}}\nteacher_1: a", r"stages\.a\.init: 'b' comes later; valid: \[\]"),
        ("stages: {a: {}}\nteacher_1: c", r"teacher_1: 'c' is not valid; valid: a"),
        ("stages: {a: {}}\nteacher: a", "teacher: unknown; valid: about, "),
        ("teacher_1: a", "stages: missing"),
        ("- a", "holds no mapping"),
    ):
        with pytest.raises(ValueError, match=message):
            read_recipe(write(text))
    with pytest.raises(ValueError, match=r"config: 'wo_hands' is neither a file nor one of .*wo_distance"):
        read_recipe("wo_hands")
    assert (CONFIG_FOLDER / "teacher_stage1.yaml").is_file()


def test_every_task_gets_its_turn():
    tasks = list(range(10))
    seen = [share_of_tasks(tasks, 4, 3, turn) for turn in range(5)]
    assert sorted(task for share in seen for task in share) == sorted(tasks * 2)
    assert share_of_tasks(tasks, 25, 3, 0).count(0) in (2, 3)
    assert seen[0] == share_of_tasks(tasks, 4, 3, 0)
