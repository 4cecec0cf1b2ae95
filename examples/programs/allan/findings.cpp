#include "findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "support/program_files.hpp"

namespace wayfare::examples {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0, kMilliG = 9.80665e-3;
constexpr std::array kAxisNames = {"gyro x",          "gyro y",          "gyro z",
                                   "accelerometer x", "accelerometer y", "accelerometer z"};

/// A unit of data sheets.
struct Unit {
  const char* name;
  double si;  ///< its value in SI
};
struct Units {
  Unit random_walk, bias, rate_random_walk;
};
const Units kGyro = {
    {"°/√h", kDegree / 60.0}, {"°/h", kDegree / 3600.0}, {"°/h/√h", kDegree / 216000.0}};
const Units kAccelerometer = {{"m/s/√s", 1.0}, {"mg", kMilliG}, {"mg/√h", kMilliG / 60.0}};

const Units& units_of(std::size_t axis) { return axis < 3 ? kGyro : kAccelerometer; }

std::string with_sigma(double value, double sigma, const Unit& unit) {
  if (value == 0.0) return "not found";
  return eval::significant(value / unit.si) + " ± " + eval::significant(sigma / unit.si, 2) + " " +
         unit.name;
}

std::string range_of(const AllanCoefficient& c) {
  return c.to_s == 0.0 ? "–"
                       : eval::significant(c.from_s) + " – " + eval::significant(c.to_s) + " s";
}

}  // namespace

UnitFit fit_unit(const RestRecord& record) {
  UnitFit fit;
  for (const AxisRecord& a : record.axes) {
    AllanCurve curve = a.allan.allan();
    const AllanFit allan = fit_allan(curve);
    fit.push_back({std::move(curve), a.allan.hadamard(), allan, a.slow.fit()});
  }
  return fit;
}

ImuNoise nominal_noise(const UnitFit& fit) {
  ImuNoise noise;
  const auto take = [&fit](std::size_t first, Eigen::Vector3d& white, GaussMarkov3& bias) {
    for (std::size_t i = 0; i < 3; ++i) {
      const AxisFit& f = fit[first + i];
      const auto k = static_cast<Eigen::Index>(i);
      if (f.allan.random_walk.value > 0.0) white[k] = f.allan.random_walk.value;
      if (f.slow.found) {
        bias.sigma[k] = f.slow.sigma;
        bias.tau_s[k] = f.slow.tau_s;
      } else if (f.allan.floor > 0.0) {
        bias.sigma[k] = f.allan.floor;
        bias.tau_s[k] = f.allan.floor_tau_s;
      }
    }
  };
  take(0, noise.gyro_white_rad_per_sqrt_s, noise.gyro_bias_radps);
  take(3, noise.accel_white_mps_per_sqrt_s, noise.accel_bias_mps2);
  return noise;
}

eval::Table allan_table(const UnitFit& fit) {
  eval::Table table({{"axis"},
                     {"random walk N"},
                     {"at"},
                     {"bias instability B"},
                     {"at"},
                     {"rate random walk K"},
                     {"at"},
                     {"minimum / 0.664"},
                     {"at", "s"}});
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const AllanFit& f = fit[i].allan;
    const Units& u = units_of(i);
    table.add_row(
        {kAxisNames[i], with_sigma(f.random_walk.value, f.random_walk.sigma, u.random_walk),
         range_of(f.random_walk),
         with_sigma(f.bias_instability.value, f.bias_instability.sigma, u.bias),
         range_of(f.bias_instability),
         with_sigma(f.rate_random_walk.value, f.rate_random_walk.sigma, u.rate_random_walk),
         range_of(f.rate_random_walk), eval::significant(f.floor / u.bias.si) + " " + u.bias.name,
         eval::significant(f.floor_tau_s)});
  }
  return table;
}

eval::Table gauss_markov_table(const UnitFit& fit) {
  eval::Table table({{"axis"}, {"Gauss-Markov σ"}, {"in SI units"}, {"correlation time τ", "s"}});
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const GaussMarkovFit& g = fit[i].slow;
    if (!g.found) {
      table.add_row({kAxisNames[i], "not found", "–", "–"});
      continue;
    }
    const Unit& u = units_of(i).bias;
    table.add_row({kAxisNames[i], with_sigma(g.sigma, g.sigma_sigma, u),
                   eval::significant(g.sigma) + (i < 3 ? " rad/s" : " m/s²"),
                   eval::significant(g.tau_s) + " ± " + eval::significant(g.tau_sigma_s, 2)});
  }
  return table;
}

std::vector<std::string> remarks(const UnitFit& fit) {
  std::vector<std::string> all;
  const auto spread = [&](std::size_t first, const char* what, auto value) {
    double low = 0.0, high = 0.0;
    for (std::size_t i = first; i < first + 3; ++i) {
      const double v = value(fit[i]);
      if (!(v > 0.0)) continue;
      low = low == 0.0 ? v : std::min(low, v);
      high = std::max(high, v);
    }
    if (low > 0.0)
      all.push_back(std::string(first == 0 ? "gyro " : "accelerometer ") + what +
                    ": ratio of the largest to the smallest axis " +
                    eval::significant(high / low, 2));
  };
  for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
    spread(first, "random walk", [](const AxisFit& f) { return f.allan.random_walk.value; });
    spread(first, "Gauss-Markov σ", [](const AxisFit& f) { return f.slow.sigma; });
    spread(first, "Gauss-Markov τ", [](const AxisFit& f) { return f.slow.tau_s; });
  }
  return all;
}

std::vector<io::Plot> allan_plots(const UnitFit& fit) {
  constexpr const char* kTime = "log10 of the averaging time [s]";
  std::vector<io::Plot> plots = {
      {"Gyro: Allan deviation (dashed: Hadamard)", kTime, "log10 of the deviation [°/h]", {}},
      {"Accelerometer: Allan deviation (dashed: Hadamard)",
       kTime,
       "log10 of the deviation [mg]",
       {}}};
  for (const bool hadamard : {false, true}) {
    for (std::size_t i = 0; i < fit.size(); ++i) {
      io::Series s{std::string(kAxisNames[i]) + (hadamard ? ", Hadamard" : ""),
                   {},
                   {},
                   hadamard ? io::Mark::dashed : io::Mark::line};
      for (const AllanPoint& p : hadamard ? fit[i].hadamard : fit[i].curve)
        if (p.relative_sigma <= 0.5)
          s.add(std::log10(p.tau_s), std::log10(p.deviation / units_of(i).bias.si));
      plots[i < 3 ? 0 : 1].series.push_back(std::move(s));
    }
  }
  return plots;
}

}  // namespace wayfare::examples
