"""Programs of the core's shading machine: what a node tree is compiled into.

The instruction set is the core's own table (`OPERATIONS`); a builder looks numbers up by name, so that nothing is
written down twice.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from . import _core


class Operation(NamedTuple):
    """One row of the instruction set. `choices`: for each immediate the names of its values, empty for a number."""

    number: int
    outputs: int
    operands: int
    choices: tuple[tuple[str, ...], ...]


OPERATIONS: dict[str, Operation] = {
    name: Operation(number, outputs, operands, tuple(map(tuple, choices)))
    for number, (name, outputs, operands, choices) in enumerate(_core.Scene._opcodes())
}


@dataclass(frozen=True)
class Program:
    """code (n,) int32, constants (m, 3) float64, table (k, 4) float32 (entries of color ramps); `owner` is for the
    messages of who made it, as in "Material 'Wall'"."""

    code: np.ndarray
    constants: np.ndarray
    table: np.ndarray
    owner: str = ""


class ProgramBuilder:
    """Writes a program instruction by instruction.

    Operands are integers: registers that `emit` has returned, or constants that `constant` has returned.
    """

    def __init__(self) -> None:
        self._code: list[int] = []
        self._constants: dict[tuple[float, float, float], int] = {}
        self._table: list[tuple[float, float, float, float]] = []
        self._registers = 0

    def constant(self, value: float | Sequence[float]) -> int:
        """The operand of a constant: a number (three times the same) or three numbers. NaN and infinity become 0."""
        triple = np.broadcast_to(np.asarray(value, float), 3)
        key = tuple(np.where(np.isfinite(triple), triple, 0.0).tolist())
        return -1 - self._constants.setdefault(key, len(self._constants))

    def value_of(self, operand: int) -> tuple[float, float, float] | None:
        """The constant behind an operand, or None for a register."""
        return list(self._constants)[-1 - operand] if operand < 0 else None

    def table(self, entries: np.ndarray) -> tuple[int, int]:
        """Adds entries (k, 4) to the table; returns start and count, two immediates."""
        start = len(self._table)
        self._table.extend(map(tuple, np.asarray(entries, np.float32).tolist()))
        return start, len(self._table) - start

    def emit(self, name: str, *operands: int, immediates: Sequence[int | str] = ()) -> tuple[int, ...]:
        """Adds an instruction and returns its output registers. Immediates are numbers or names out of the choices.

        Raises KeyError for an unknown operation, ValueError for an unknown name or a wrong number of arguments.
        """
        operation = OPERATIONS[name]
        if len(operands) != operation.operands or len(immediates) != len(operation.choices):
            raise ValueError(
                f"{name}: expected {operation.operands} operands and {len(operation.choices)} immediates, "
                f"got {len(operands)} and {len(immediates)}"
            )
        numbers = []
        for choices, value in zip(operation.choices, immediates, strict=True):
            if isinstance(value, str) and value not in choices:
                raise ValueError(f"{name}: {value!r} is none of {', '.join(choices)}")
            numbers.append(choices.index(value) if isinstance(value, str) else int(value))
        outputs = tuple(range(self._registers, self._registers + operation.outputs))
        self._code += [operation.number, self._registers, *operands, *numbers]
        self._registers += operation.outputs
        return outputs

    def build(self, owner: str = "") -> Program:
        """The program so far."""
        return Program(
            np.array(self._code, np.int32),
            np.array(list(self._constants), np.float64).reshape(-1, 3),
            np.array(self._table, np.float32).reshape(-1, 4),
            owner,
        )
