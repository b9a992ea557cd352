"""A trained policy as a controller: alone, or as a correction of another controller's command."""

from __future__ import annotations

from dataclasses import dataclass

from trackers.belief.command_shares import command_of, is_seen, shares_of
from trackers.belief.feature_filter import FeatureKeeper
from trackers.controllers.catalogue import create_controller
from trackers.controllers.policy_file import load_policy
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class PolicyParameters:
    """Setting of the controller.

    Attributes:
        file: of the policy, see ``trackers.controllers.policy_file.load_policy``.
    """

    file: str


class PolicyController:
    """Does with every picture what the env did in training: belief, features, network, command."""

    Parameters = PolicyParameters

    def __init__(self, parameters: PolicyParameters) -> None:
        self.parameters = parameters
        self._policy = policy = load_policy(parameters.file)
        self._features = FeatureKeeper(policy.carrier)
        self._given = CameraCommand()
        base = policy.base
        self._base = None
        if base is not None:
            self._base = create_controller(base["controller"], policy.carrier.name, **base["parameters"])

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command of the policy's mean action."""
        policy = self._policy
        features = self._features.update(observation, estimate, self._given)
        shares = policy.action(features[None])[0]
        if self._base is not None:
            own = self._base.command(observation, estimate)
            if policy.corrects == "unseen" and is_seen(estimate):
                self._given = own
                return own
            shares = shares_of(policy.carrier, own) + policy.correction_share * shares
        self._given = command_of(policy.carrier, shares)
        return self._given
