// Dead reckoning with a step length model of one's own: this person's steps grow with the step
// frequency. Calibrated on a minute of known length at one frequency, tested at others.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

using namespace wayfare;
struct FrequencyStep {
  double factor = 1.0;
  double operator()(const Step& step) const {
    return factor * (0.3 + 0.25 / std::max(step.interval_s, 0.3));
  }
};

struct Walk {
  MargRecording samples;
  double length_m = 0.0;
};
// A phone ahead in the hand: minutes at these step frequencies, Hz, after seconds at rest.
Walk walk(const std::vector<double>& frequencies) {
  Rng rng(1);
  Walk w;
  double phase = 0.0;
  for (int i = 0; i < int(500 + 6000 * frequencies.size()); ++i) {
    const double hz = i < 500 ? 0.0 : frequencies[std::size_t(i - 500) / 6000];
    phase += 0.01 * hz;
    w.length_m += 0.01 * hz * 0.9 * (0.3 + 0.25 * hz);
    const double bounce = hz == 0.0 ? 0.0 : 3.0 * std::cos(2.0 * std::numbers::pi * phase);
    MargSample s{LogTime::from_nanoseconds(std::int64_t(i + 1) * 10'000'000)};
    s.angular_rate_radps.setZero();
    s.specific_force_mps2 = {0.1 * rng.normal(), 0.1 * rng.normal(), 9.80665 + bounce};
    w.samples.push_back(s);
  }
  return w;
}

template <class Length>
double error_of(const Walk& w, const Length& model) {
  BasicPedestrianParameters<Length> parameters;
  parameters.ahrs.use_magnetometer = false;
  const Walk known = walk({1.6});
  std::vector<Step> steps;
  StepDetector detector(parameters.steps);
  for (const MargSample& s : known.samples)
    detector.add(s.time, s.specific_force_mps2, [&](const Step& step) { steps.push_back(step); });
  parameters.length = calibrated(model, steps, known.length_m);
  BasicPedestrian pedestrian(parameters);
  for (const MargSample& s : w.samples) pedestrian.add(s);
  return 100.0 * (pedestrian.report().distance_m / w.length_m - 1.0);
}

int main() {
  const Walk w = walk({1.5, 1.8, 2.1, 2.4});
  std::printf("distance: KimStep %+.1f %%, ", error_of(w, KimStep{}));
  std::printf("FrequencyStep %+.1f %%\n", error_of(w, FrequencyStep{}));
}
