// Validity of a match.

#include <wayfare/slam/detail/check_match.hpp>

#include <cmath>
#include <string>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/slam/detail/scans.hpp>

namespace wayfare::detail {
namespace {

bool finite(const SceneConstraint& constraint) {
  return constraint.weakest.allFinite() && std::isfinite(constraint.share) &&
         !std::isnan(constraint.displacement_cost_nats);
}

}  // namespace

Result<void> check_match(const MatchResult& match) {
  const auto not_finite = [](const char* what) {
    return Error{ErrorCode::numerical,
                 std::string("the matcher's result is not finite: its ") + what};
  };
  if (!finite(match.T_map_points)) return not_finite("pose");
  if (!std::isfinite(match.score)) return not_finite("score");
  if (match.constraint && !finite(*match.constraint)) return not_finite("constraint");
  if (!match.covariance) return {};
  if (!match.covariance->allFinite()) return not_finite("covariance");
  if (!is_positive_semidefinite(*match.covariance))
    return Error{ErrorCode::numerical, "the matcher's covariance is not positive semi-definite"};
  return {};
}

}  // namespace wayfare::detail
