"""From a solver's claim to a plan: certified against the Model, decoded, verified. Once, here.

No answer is shown before both checks. A point that the Model accepts and the verifier refuses is
our own disagreement (exit 70), never a plan.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stlc.backends.base import Solution, SolveOptions
from stlc.errors import DisagreementError, SolverError
from stlc.milp.compile import Compiled
from stlc.mission import Mission

if TYPE_CHECKING:
    from stlc.plan import Plan
    from stlc.solve.certify import Certified
    from stlc.verify import Report


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Judges claims about one compiled mission; `encoding` is what reports call it."""

    mission: Mission
    compiled: Compiled
    encoding: str = "auto"

    def judge(self, claim: Solution, asked: SolveOptions | None = None) -> tuple[Plan, Report]:
        """The plan of a claim, and the verifier's verdict on it.

        A point that the verifier refuses is looked at once more with a continuous part that keeps
        the Model more exactly. `asked` are the options that the claim is held against. SolverError
        when certification refuses the point.
        """
        from stlc.solve.certify import certify, sharpened

        certified = certify(self.compiled.model, claim, options=asked)
        plan, report = self._verified(certified)
        if report.ok:
            return plan, report
        return self._verified(sharpened(self.compiled.model, certified, asked))

    def _verified(self, certified: Certified) -> tuple[Plan, Report]:
        """The plan of a certified point, and the verifier's verdict on it."""
        from stlc.certificate import Certificate
        from stlc.plan import SolveInfo, make_plan
        from stlc.verify import verify

        claim, sense = certified.claim, self.mission.sense
        if certified.x is None:
            raise SolverError(f"{claim.solver} gave no point")
        run = self.compiled.decode(certified.x)
        info = SolveInfo(
            certified.status.value, sense.own(certified.objective), sense.own(certified.bound),
            certified.gap, claim.solver, claim.solver_version, self.encoding, sense=sense,
        )  # fmt: skip
        plan = make_plan(self.mission, run.states, run.inputs, info)
        report = verify(self.mission, plan, self.compiled.channels)
        return report.annotate(plan, Certificate(certified.checked(sense))), report

    def accept(self, claim: Solution, asked: SolveOptions | None = None) -> tuple[Plan, Report]:
        """As `judge`; DisagreementError when the verifier refuses what the Model accepts."""
        plan, report = self.judge(claim, asked)
        if not report.ok:
            raise DisagreementError(
                f"the plan of {claim.solver or 'a solver'} satisfies the compiled model but not "
                f"the mission; this is a bug in stlc:\n{report.text()}"
            )
        return plan, report
