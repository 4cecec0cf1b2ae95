// Smoothing: the path of a cart by all measurements, those after an instant included. Its position
// is measured before and after a tunnel; in it the filter drifts, the smoother has both ends.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/smoother.hpp>

using namespace wayfare;
using Cart = Eigen::Vector2d;  // position, m, and speed, m/s

struct Roll {
  struct Step {
    Cart state;
    Eigen::Matrix2d phi, q;
  };
  Step operator()(const Cart& x, double dt_s) const {
    Eigen::Matrix2d phi;
    phi << 1.0, dt_s, 0.0, 1.0;
    return {phi * x, phi, Cart(0.0, 0.01 * dt_s).asDiagonal()};
  }
};

struct Position {
  static constexpr int kDim = 1;
  double measured_m;
  Eigen::Matrix<double, 1, 1> error(const Cart& x) const {  // in standard deviations
    return Eigen::Matrix<double, 1, 1>((x[0] - measured_m) / 0.1);
  }
};

int main() {
  Ekf<Cart, TapeRecorder<Cart>> filter(Cart(0.0, 2.0), Cart(1.0, 1.0).asDiagonal());
  SmootherTape<Cart> tape;
  filter.recorder().tape = &tape;
  Rng rng(4);
  std::vector<double> truth;
  double position = 0.0, speed = 2.0, filtered_m = 0.0, smoothed_m = 0.0;
  for (int k = 0; k < 600; ++k) {  // a minute at 10 Hz, in a tunnel from 20 s to 40 s
    position += 0.1 * speed;
    speed += rng.normal(0.0, std::sqrt(0.01 * 0.1));
    truth.push_back(position);
    filter.predict(Roll{}, 0.1);
    if (k < 200 || k >= 400) filter.update(Position{position + rng.normal(0.0, 0.1)});
    filtered_m = std::max(filtered_m, std::abs(filter.state()[0] - position));
    tape.mark(filter.state(), filter.covariance());  // an instant to smooth
  }
  SmootherAdjoint<Cart> adjoint;
  tape.back(adjoint, [&](std::size_t k, const auto& mark, const auto& later) {
    const Cart x = smoothed<Cart>(mark, later).state;
    smoothed_m = std::max(smoothed_m, std::abs(x[0] - truth[k]));
  });
  std::printf("largest error: filter %.2f m, smoother %.2f m\n", filtered_m, smoothed_m);
}
