#include "links.hpp"

#include <cmath>

#include <wayfare/filter.hpp>

// After two time constants a first-order Gauss-Markov state keeps e^-2.
bool filters() {
  const auto step = wayfare::discretise_gauss_markov(1.0, 3.0, 6.0);
  return std::abs(step.phi - std::exp(-2.0)) < 1e-12;
}
