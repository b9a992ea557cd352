"""A trained policy as a controller: alone, or as a correction of another controller's command."""

from __future__ import annotations

from dataclasses import dataclass

from trackers.belief.features import FeatureFilter, command_of, is_seen, shares_of
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.policy_file import load_policy
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class PolicyParameters:
    """Settings.

    Attributes:
        file: the policy, see ``trackers.controllers.policy_file.load_policy``.
    """

    file: str


class PolicyController:
    """Computes belief, features, network and command of every picture, as the env does in training."""

    Parameters = PolicyParameters

    def __init__(self, parameters: PolicyParameters) -> None:
        self.parameters = parameters
        self._policy = policy = load_policy(parameters.file)
        self._features = FeatureFilter(policy.carrier)
        self._given = CameraCommand()
        base = policy.base
        self._base = None
        if base is not None:
            self._base = controller_entry(base["controller"], policy.carrier.name).create(**base["parameters"])

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command of the policy's mean action."""
        policy = self._policy
        features = self._features.update(observation, estimate, self._given)
        shares = policy.action(features[None])[0]
        if self._base is not None:
            base = self._base.command(observation, estimate)
            if policy.corrects == "unseen" and is_seen(estimate):
                self._given = base
                return base
            shares = shares_of(policy.carrier, base) + policy.correction_share * shares
        self._given = command_of(policy.carrier, shares)
        return self._given
