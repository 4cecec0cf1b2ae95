#include "links.hpp"

#include <wayfare/match/correlative.hpp>

bool matches_scans() {
  const auto match = wayfare::CorrelativeMatcher().match(
      wayfare::LikelihoodField(), wayfare::PointSet(), wayfare::SE2d(), wayfare::SearchWindow());
  return !match || !match->has_value();
}
