// Adaptive Monte-Carlo localisation composed of free parts: a likelihood field, a differential
// drive, KLD sampling and random injection. The robot is anywhere in a drawn room at first.
#include <cstdint>
#include <cstdio>
#include <vector>

#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/filter/pose_bins.hpp>
#include <wayfare/map/distance_field.hpp>
#include <wayfare/motion/differential_drive_model.hpp>

using namespace wayfare;
int main() {
  constexpr int kWidth = 120, kHeight = 80, kBeams = 60;  // cells of 0.1 m
  std::vector<std::uint8_t> walls;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool border = x == 0 || y == 0 || x == kWidth - 1 || y == kHeight - 1;
      const bool wall = (x > 39 && x < 42 && y < 30) || (x > 99 && y > 9 && y < 20);
      walls.push_back(border || wall ? 1 : 0);
    }
  const auto distances = DistanceField::of_mask(walls, kWidth, kHeight, 0.1);
  const auto field = likelihood_field(*distances, {0.3, 0.05});
  const RayCaster scanner(*distances);
  std::vector<float> cosines, sines, ranges(kBeams);
  for (int i = 0; i < kBeams; ++i) {
    const SO2d bearing(Angle::degrees(360.0 * i / kBeams));
    cosines.push_back(static_cast<float>(bearing.cos()));
    sines.push_back(static_cast<float>(bearing.sin()));
  }
  const auto anywhere = [](Rng& rng) {
    const Angle heading = Angle::degrees(rng.uniform(-180.0, 180.0));
    return SE2d(rng.uniform(0.0, 12.0), rng.uniform(0.0, 8.0), heading);
  };
  const Rng rng(1);
  auto particles = draw_particles(40000, anywhere, rng.stream(0));
  SE2d truth(6.0, 1.5, Angle());
  RecoveryProbability recovery;
  const KldSampling kld{0.05, 2.326, 2000, 40000};
  for (std::uint64_t k = 1; k <= 40; ++k) {
    Rng own = rng.stream(k);
    const Gaussian<SE2d> motion = DifferentialDriveModel{0.4, 0.02}(0.13, 0.15);  // of the wheels
    truth = truth * sample(motion, own);
    scanner.cast(truth, cosines, sines, 15.0, ranges);
    const auto drive = [&](const SE2d& x, Rng& r) { return x * sample(motion, r); };
    propagate(particles, drive, own.stream(0));
    const Normalisation fit = reweight(particles, [&](const SE2d& x) {
      double sum = 0.0;
      for (std::size_t i = 0; i < kBeams; ++i)
        sum += field->log_likelihood(
            cell_of(x * Eigen::Vector2d(ranges[i] * cosines[i], ranges[i] * sines[i]), 0.1));
      return 6.0 / kBeams * sum;  // neighbouring beams are correlated: as of 6
    });
    particles = resample_adaptively(particles, PoseBins(0.5, Angle::degrees(15)), kld, own);
    inject(particles, recovery.update(fit.log_sum), anywhere, own.stream(1));
  }
  const Eigen::Vector2d off =
      mean_and_covariance(particles).mean.translation() - truth.translation();
  std::printf("robot: %.3f m off, %zu particles\n", off.norm(), particles.size());
}
