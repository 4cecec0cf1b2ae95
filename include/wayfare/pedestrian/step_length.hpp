#pragma once

// Step length models. Models are const callables.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <span>
#include <variant>

#include <wayfare/pedestrian/step_detector.hpp>

namespace wayfare {

/// Returns metres; `factor` scales all lengths, so that one calibration serves every model.
template <class M>
concept StepLengthModel = requires(M m, const M& c, const Step& step) {
  { c(step) } -> std::same_as<double>;
  { m.factor } -> std::same_as<double&>;
};

/// Constant length: distance over number of steps (Sadruddin 2020, 2.6.3).
struct ConstantStep {
  double factor = 0.69;  ///< m
  double operator()(const Step& /*step*/) const { return factor; }
};

/// Range of the acceleration within the step: k·(a_max − a_min)^¼ (Weinberg 2002).
struct WeinbergStep {
  double factor = 0.434;  ///< m·(m/s²)^-¼
  double operator()(const Step& s) const {
    return factor * std::pow(std::max(0.0, s.crest_mps2 - s.trough_mps2), 0.25);
  }
};

/// Mean magnitude of the acceleration within the step: k·(Σ|a|/n)^⅓ (Kim et al. 2004).
struct KimStep {
  double factor = 0.545;  ///< m·(m/s²)^-⅓
  double operator()(const Step& s) const {
    return factor * std::cbrt(std::max(0.0, s.mean_abs_mps2));
  }
};

/// Body height and step frequency: k·h·√f (Tian et al. 2015).
struct HeightFrequencyStep {
  double factor = 0.3139;
  double height_m = 1.75;
  double operator()(const Step& s) const {
    return factor * height_m * std::sqrt(1.0 / std::max(s.interval_s, 0.2));
  }
};

using StepLength = std::variant<KimStep, ConstantStep, WeinbergStep, HeightFrequencyStep>;

[[nodiscard]] inline double length_of(const Step& step, const StepLength& model) {
  return std::visit([&](const auto& m) { return m(step); }, model);
}

/// The model with its factor calibrated so that the steps of a walk add up to its known length.
/// Unchanged if they add up to zero.
[[nodiscard]] inline StepLength calibrated(StepLength model, std::span<const Step> steps,
                                           double length_m) {
  double sum = 0.0;
  for (const Step& s : steps) sum += length_of(s, model);
  if (sum > 0.0 && length_m > 0.0) std::visit([&](auto& m) { m.factor *= length_m / sum; }, model);
  return model;
}

}  // namespace wayfare
