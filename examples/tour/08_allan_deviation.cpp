// From the record of a gyro at rest to the parameters of a navigation filter: white noise from the
// Allan deviation, a slowly varying bias from the autocorrelation.
#include <cmath>
#include <cstdio>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/imu_noise.hpp>

using namespace wayfare;

int main() {
  constexpr double kPeriod_s = 0.1, kWhite = 1e-4, kSigma = 3e-5, kTau_s = 200.0;
  AllanRecorder allan(kPeriod_s);
  AutocorrelationRecorder slow(kPeriod_s);

  Rng rng(1);
  double bias = rng.normal(0.0, kSigma);  // a Gauss-Markov process
  const double kept = std::exp(-kPeriod_s / kTau_s);
  for (int i = 0; i < 360'000; ++i) {  // ten hours, rad/s
    bias = kept * bias + rng.normal(0.0, kSigma * std::sqrt(1.0 - kept * kept));
    const double reading = bias + rng.normal(0.0, kWhite / std::sqrt(kPeriod_s));
    allan.add(reading);
    slow.add(reading);
  }

  for (const AllanPoint& point : allan.allan())
    if (point.tau_s == 0.1 || point.tau_s == 1.6 || point.tau_s == 204.8)
      std::printf("%6.1f s: %.1e rad/s\n", point.tau_s, point.deviation);

  const AllanFit white = fit_allan(allan.allan());
  const GaussMarkovFit process = slow.fit();
  ImuNoise noise;  // as GnssInsOptions::imu takes it
  noise.gyro_white_rad_per_sqrt_s.setConstant(white.random_walk.value);
  noise.gyro_bias_radps.sigma.setConstant(process.sigma);
  noise.gyro_bias_radps.tau_s.setConstant(process.tau_s);
  std::printf("white noise %.2e rad/sqrt(s), bias %.1e rad/s over %.0f s\n",
              noise.gyro_white_rad_per_sqrt_s.x(), noise.gyro_bias_radps.sigma.x(),
              noise.gyro_bias_radps.tau_s.x());
}
