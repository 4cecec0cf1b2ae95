// Random calls of the particle filter and of the extended Kalman filter, each compared with a model
// that has no storage of its own: whole trajectories per particle, and the textbook's matrices.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/rbpf.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

/// A map that records where it has been, and may not be shared by accident.
using Trail = std::vector<double>;
using Particles = Rbpf<Trail>;

/// Every particle with its whole past, weights by log-sum-exp in the widest numbers there are.
struct ParticleModel {
  struct One {
    Trail trail;
    std::vector<double> path;
    double evidence = 0.0;
    long double log_weight = 0.0L;
  };
  std::vector<One> all;

  explicit ParticleModel(std::size_t n) : all(n) {
    for (One& p : all) {
      p.path.push_back(0.0);
      p.log_weight = -std::log(static_cast<long double>(n));
    }
  }

  bool weigh(const std::vector<double>& factors) {
    std::vector<double> next;
    for (std::size_t i = 0; i < all.size(); ++i)
      next.push_back(static_cast<double>(all[i].log_weight) + factors[i]);
    double max = -kInf;
    for (const double w : next)
      if (w < kInf) max = std::max(max, w);
    if (!(max > -kInf)) return false;
    long double sum = 0.0L;
    for (const double w : next)
      if (w < kInf) sum += std::exp(static_cast<long double>(w) - static_cast<long double>(max));
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double w = next[i] < kInf ? next[i] - max - static_cast<double>(std::log(sum)) : -kInf;
      all[i].log_weight = w;
      constexpr double kMost = std::numeric_limits<double>::max();
      all[i].evidence = w > -kInf ? std::clamp(all[i].evidence + factors[i], -kMost, kMost) : -kInf;
    }
    return true;
  }
};

void expect_same(const Particles& filter, const ParticleModel& model) {
  ASSERT_EQ(filter.particles().size(), model.all.size());
  double best = -kInf;
  std::size_t nodes = 0, longest = 0;
  for (std::size_t i = 0; i < model.all.size(); ++i) {
    const auto& m = model.all[i];
    const auto w = static_cast<double>(m.log_weight);
    if (std::isinf(w)) {
      ASSERT_EQ(filter.log_weights()[i], w);
    } else {
      ASSERT_NEAR(filter.log_weights()[i], w, 1e-9 * (1.0 + std::abs(w)));
    }
    ASSERT_EQ(filter.particles()[i].map, m.trail);
    ASSERT_EQ(filter.particles()[i].log_evidence, m.evidence);
    const Trajectory path = filter.trajectory(i);
    ASSERT_EQ(path.size(), m.path.size());
    for (std::size_t k = 0; k < path.size(); ++k)
      ASSERT_EQ(path[k].T_map_base.raw().x(), m.path[k]);
    if (w > -kInf) best = std::max(best, m.evidence);
    nodes += m.path.size();
    longest = std::max(longest, m.path.size());
  }
  ASSERT_LE(filter.stored_poses(), nodes);
  ASSERT_GE(filter.stored_poses(), longest);
  ASSERT_GT(filter.log_weights()[filter.best()], -kInf);
  ASSERT_EQ(filter.particles()[filter.best()].log_evidence, best);
}

/// One update with factors drawn here, so that filter and model see the same numbers.
void update_both(Particles& filter, ParticleModel& model, int step, Rng& rng) {
  constexpr std::array kOdd{kNan, kInf, -kInf, 1e308, -1e308, -1.7e308, 700.0, -2000.0};
  std::vector<double> factors, poses;
  const std::uint64_t odd = rng.below(4);
  for (std::size_t i = 0; i < model.all.size(); ++i) {
    factors.push_back(rng.below(4) < odd ? kOdd[rng.below(kOdd.size())] : rng.uniform(-3.0, 3.0));
    poses.push_back(rng.normal());
  }
  if (rng.below(8) == 0) std::fill(factors.begin(), factors.end(), -1e308);
  const auto said = filter.update(
      LogTime::from_seconds(step),
      [&](auto& particle, Rng&, std::size_t) {
        const auto i = static_cast<std::size_t>(&particle - filter.particles().data());
        particle.pose = SE2d(poses[i], 0.0, Angle{});
        particle.map.push_back(poses[i]);
        return factors[i];
      },
      [](std::size_t n, const auto& f) {  // in any order
        for (std::size_t i = n; i-- > 0;) f(i, 0);
      });
  for (std::size_t i = 0; i < model.all.size(); ++i) {
    model.all[i].trail.push_back(poses[i]);
    model.all[i].path.push_back(poses[i]);
  }
  ASSERT_EQ(said.has_value(), model.weigh(factors));
}

/// The particles drawn are found by their trails: all of them are different.
void resample_both(Particles& filter, ParticleModel& model, double fraction) {
  const double n = static_cast<double>(model.all.size());
  const double effective = filter.effective_particles();
  ASSERT_EQ(filter.resample_below(fraction), effective < fraction * n);
  if (!(effective < fraction * n)) return;
  std::vector<ParticleModel::One> drawn;
  for (const auto& particle : filter.particles()) {
    const auto from = std::find_if(model.all.begin(), model.all.end(),
                                   [&](const auto& m) { return m.trail == particle.map; });
    ASSERT_NE(from, model.all.end());
    ASSERT_GT(from->log_weight, -kInf);
    drawn.push_back(*from);
    drawn.back().log_weight = -std::log(n);
  }
  model.all = std::move(drawn);
}

TEST(RbpfCalls, AnyOrderFollowsParticlesWithTheirWholePast) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const std::size_t n = 1 + rng.below(12);
    Particles filter(n, StampedPose{}, {}, seed);
    ParticleModel model(n);
    std::optional<Particles> kept;
    std::optional<ParticleModel> kept_model;
    std::string calls;
    for (int step = 1; step <= 40; ++step) {
      switch (rng.below(8)) {
        case 0:
          calls += " copy";
          kept.emplace(filter);
          kept_model.emplace(model);
          break;
        case 1:
          if (!kept) break;
          calls += " back";
          filter = *kept;
          model = *kept_model;
          break;
        case 2: {
          calls += " move";
          Particles moved(std::move(filter));
          filter = std::move(moved);
          break;
        }
        case 3:
        case 4:
          calls += " resample";
          resample_both(filter, model, rng.uniform(0.0, 1.2));
          break;
        default:
          calls += " update";
          update_both(filter, model, step, rng);
      }
      SCOPED_TRACE(calls);
      expect_same(filter, model);
      if (::testing::Test::HasFatalFailure()) return;
    }
    if (kept) {
      expect_same(*kept, *kept_model);
    }
  }
}

using Vector4 = Eigen::Vector4d;
using Square4 = Eigen::Matrix4d;
using Row4 = Eigen::Matrix<double, 1, 4>;

struct Step4 {
  Vector4 state;
  Square4 phi, q;
};

/// Gelb 1974, table 4.2-1, with an explicit inverse and Joseph's form.
struct Textbook {
  Vector4 x = Vector4::Zero();
  Square4 p = Square4::Identity();

  void predict(const Square4& phi, const Square4& q) {
    x = phi * x;
    p = phi * p * phi.transpose() + q;
  }
  template <int Rows>
  bool update(const Eigen::Matrix<double, Rows, 1>& z, const Eigen::Matrix<double, Rows, 4>& h,
              const Eigen::Matrix<double, Rows, Rows>& r, double nis_limit) {
    const Eigen::Matrix<double, Rows, Rows> s = h * p * h.transpose() + r;
    const Eigen::Matrix<double, Rows, 1> nu = z - h * x;
    if (!s.allFinite() || !nu.allFinite() || !(s.determinant() > 0.0) || !(s(0, 0) > 0.0))
      return false;
    const Eigen::Matrix<double, Rows, Rows> inverse = s.inverse();
    if (!(nu.dot(inverse * nu) <= nis_limit)) return false;
    const Eigen::Matrix<double, 4, Rows> k = p * h.transpose() * inverse;
    x += k * nu;
    const Square4 keep = Square4::Identity() - k * h;
    p = keep * p * keep.transpose() + k * r * k.transpose();
    return true;
  }
};

template <class Matrix>
Matrix random_matrix(Rng& rng, double sigma) {
  Matrix m;
  for (double& x : m.reshaped()) x = rng.normal(0.0, sigma);
  return m;
}

double maybe_odd(double value, Rng& rng) {
  return rng.below(6) == 0 ? kNotFinite[rng.below(3)] : value;
}

void update_scalar(Ekf<Vector4>& filter, Textbook& book, Rng& rng) {
  const bool sparse = rng.below(2) == 0;
  Row4 row = random_matrix<Row4>(rng, 1.0);
  if (sparse) row[1] = row[3] = 0.0;
  const double r = maybe_odd(rng.uniform(0.01, 2.0), rng);
  const double z = maybe_odd(rng.normal(0.0, 4.0), rng), gate = rng.uniform(0.5, 5.0);
  const double nu = z - row.dot(filter.state());
  bool accepted = false;
  if (sparse) {
    const SparseRow<double, 2> two{{0, 2}, {row[0], row[2]}};
    accepted = filter
                   .update(
                       [&](const Vector4&) {
                         return ScalarMeasurement<double, SparseRow<double, 2>>{nu, two, r};
                       },
                       gate)
                   .accepted;
  } else {
    accepted = filter
                   .update(
                       [&](const Vector4&) {
                         return ScalarMeasurement<double, Row4>{nu, row, r};
                       },
                       gate)
                   .accepted;
  }
  const Eigen::Matrix<double, 1, 1> measured(z), variance(r);
  ASSERT_EQ(accepted, book.update<1>(measured, row, variance, gate * gate));
}

void update_block(Ekf<Vector4>& filter, Textbook& book, Rng& rng) {
  using Rows = Eigen::Matrix<double, 2, 4>;
  const Rows h = random_matrix<Rows>(rng, 1.0);
  const Eigen::Matrix2d root = random_matrix<Eigen::Matrix2d>(rng, 0.7);
  const Eigen::Matrix2d r = root * root.transpose() + 0.05 * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d z(maybe_odd(rng.normal(0.0, 3.0), rng), rng.normal(0.0, 3.0));
  const double limit = rng.uniform(1.0, 20.0);
  ASSERT_EQ(filter.update_block<2>(z - h * filter.state(), h, r, limit),
            book.update<2>(z, h, r, limit));
}

void change(Ekf<Vector4>& filter, Textbook& book, Rng& rng) {
  const int i = static_cast<int>(rng.below(4));
  switch (rng.below(3)) {
    case 0:
      filter.add_variance(i, 0.3);
      book.p(i, i) += 0.3;
      break;
    case 1:
      filter.reset_variance(i, 1.5);
      book.p.row(i).setZero();
      book.p.col(i).setZero();
      book.p(i, i) = 1.5;
      break;
    default:
      filter.scale_sigma(i, 4 - i, 1.2);
      const Vector4 scale =
          (Vector4() << Vector4::Ones().head(i), Vector4::Constant(1.2).head(4 - i)).finished();
      book.p = scale.asDiagonal() * book.p * scale.asDiagonal();
  }
}

TEST(EkfCalls, AnyOrderFollowsTheTextbook) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    Ekf<Vector4> filter(Vector4::Zero(), Square4::Identity());
    Textbook book;
    std::string calls;
    for (int step = 0; step < 40; ++step) {
      switch (rng.below(5)) {
        case 0: {
          calls += " predict";
          const Square4 phi = Square4::Identity() + random_matrix<Square4>(rng, 0.05);
          const Square4 q = Vector4(0.1, 0.0, 0.02, 0.3).asDiagonal();
          filter.predict([&](const Vector4& x) { return Step4{phi * x, phi, q}; });
          book.predict(phi, q);
          break;
        }
        case 1:
          calls += " block";
          update_block(filter, book, rng);
          break;
        case 2:
          calls += " change";
          change(filter, book, rng);
          break;
        default:
          calls += " scalar";
          update_scalar(filter, book, rng);
      }
      SCOPED_TRACE(calls);
      ASSERT_LT((filter.state() - book.x).norm(), 1e-7 * (1.0 + book.x.norm()));
      ASSERT_LT((filter.covariance() - book.p).norm(), 1e-7 * (1.0 + book.p.norm()));
      ASSERT_LT((filter.covariance() - filter.covariance().transpose()).norm(),
                1e-12 * (1.0 + book.p.norm()));
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace wayfare::tests
