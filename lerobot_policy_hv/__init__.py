"""LeRobot plugin: makes `--policy.type=hv` and `--env.type=hv_sim` known to every stock `lerobot-*` command.

LeRobot imports each installed distribution whose metadata name begins with `lerobot_policy_`, as a module of exactly
that name. Importing the two configuration modules registers the choices; LeRobot itself then finds `HVPolicy` and
`make_hv_pre_post_processors` beside `HVConfig` by name. Kept cheap on purpose: neither mujoco nor transformers is
imported here, because every `lerobot-*` command on this machine pays for it, whatever it is run for.
"""

from hv_policy.configuration_hv import HVConfig
from hv_policy.processor_hv import make_hv_pre_post_processors
from hv_sim.lerobot_env import HvSimEnvConfig
from lerobot_policy_hv.error_lines import report_input_errors_in_one_line

__all__ = ["HVConfig", "HvSimEnvConfig", "make_hv_pre_post_processors"]

report_input_errors_in_one_line()
