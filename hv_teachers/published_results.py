"""Tables 1 to 5 of the paper (HumanoidVerse), to be shown beside ours."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PublishedRow:
    """One row of a table: shares in 0..1, distances in m (None where the paper gives none).

    `experiment` is the name of ours that it is compared with (`configs/experiments`).
    """

    system: str
    experiment: str
    success_1: float
    success_2: float
    success_all: float
    dist_1: float | None = None
    dist_2: float | None = None


@dataclass(frozen=True)
class PublishedTable:
    """A table of the paper; `suite` is ours that stands for its tasks."""

    number: int
    title: str
    suite: str
    rows: tuple[PublishedRow, ...]


_TEACHER = PublishedRow("HumanoidVerse-T", "humanoidverse_teacher", 0.88762, 0.72857, 0.72381, 0.247, 0.484)
_STUDENT = PublishedRow("HumanoidVerse-S", "student", 0.66095, 0.42667, 0.40952, 0.503, 1.031)

PUBLISHED_TABLES = (
    PublishedTable(
        1,
        "Performance on the 350 seen tasks",
        "seen",
        (
            PublishedRow("HumanVLA-T", "humanvla_teacher", 0.42286, 0.07429, 0.05714, 0.468, 1.793),
            _TEACHER,
            PublishedRow("HumanVLA-S", "humanvla_student", 0.45714, 0.0, 0.0, 0.996, 1.971),
            _STUDENT,
        ),
    ),
    PublishedTable(
        2,
        "Other ways to train a teacher",
        "seen",
        (
            PublishedRow("End-to-End RL", "end_to_end", 0.02286, 0.0, 0.0, 2.050, 1.966),
            PublishedRow("Single Teacher", "single_teacher", 0.88286, 0.48476, 0.48190, 0.258, 1.014),
            _TEACHER,
        ),
    ),
    PublishedTable(
        3,
        "Performance on the 66 unseen tasks",
        "unseen",
        (
            PublishedRow("HumanVLA-T", "humanvla_teacher", 0.27273, 0.09091, 0.04545, 0.790, 1.848),
            PublishedRow("HumanoidVerse-T", "humanoidverse_teacher", 0.80303, 0.64646, 0.64646, 0.531, 0.723),
            PublishedRow("HumanVLA-S", "humanvla_student", 0.37879, 0.0, 0.0, 1.271, 2.043),
            PublishedRow("HumanoidVerse-S", "student", 0.56061, 0.42929, 0.40909, 0.771, 1.226),
        ),
    ),
    PublishedTable(
        4,
        "Without a stage, or without a condition of Algorithm 3",
        "seen",
        (
            _TEACHER,
            PublishedRow("w/o Training S2", "wo_stage2", 0.81048, 0.60476, 0.56190),
            PublishedRow("w/o Training S3", "wo_stage3", 0.86952, 0.35238, 0.34952),
            PublishedRow("w/o Obj Speed", "wo_speed", 0.68952, 0.69238, 0.53524),
            PublishedRow("w/o Obj2Goal Dist", "wo_distance", 0.70286, 0.77238, 0.55048),
        ),
    ),
    PublishedTable(
        5,
        "The student without one of its senses",
        "seen",
        (
            _STUDENT,
            PublishedRow("w/o Vision", "student_wo_vision", 0.0, 0.0, 0.0, 2.143, 1.988),
            PublishedRow("w/o Language", "student_wo_language", 0.00287, 0.0, 0.0, 2.298, 2.132),
            PublishedRow("w/o Proprioception", "student_wo_proprioception", 0.0, 0.0, 0.0, 2.148, 1.964),
        ),
    ),
)
