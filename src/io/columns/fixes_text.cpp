#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"
#include "io/columns/nav_columns.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

constexpr std::array kFix = {
    Quantity{"lat", Dimension::angle},    Quantity{"lon", Dimension::angle},
    Quantity{"h", Dimension::length},     Quantity{"sn", Dimension::length},
    Quantity{"se", Dimension::length},    Quantity{"sd", Dimension::length},
    Quantity{"sne", Dimension::length},   Quantity{"seu", Dimension::length},
    Quantity{"sun", Dimension::length},   Quantity{"vn", Dimension::speed},
    Quantity{"ve", Dimension::speed},     Quantity{"vd", Dimension::speed},
    Quantity{"svn", Dimension::speed},    Quantity{"sve", Dimension::speed},
    Quantity{"svd", Dimension::speed},    Quantity{"vu", Dimension::speed},
    Quantity{"sh", Dimension::length},    Quantity{"sv_h", Dimension::length},
    Quantity{"speed", Dimension::speed},  Quantity{"course", Dimension::angle},
    Quantity{"sspeed", Dimension::speed}, Quantity{"q", Dimension::none}};

/// Variances from standard deviations.
Eigen::Matrix3d variances(const Eigen::Vector3d& sigma) { return sigma.cwiseAbs2().asDiagonal(); }

/// RTKLIB writes signed roots of covariances, with the third axis up.
void add_covariances(const Eigen::Vector3d& ne_eu_un, Eigen::Matrix3d& covariance) {
  if (!ne_eu_un.allFinite()) return;
  const auto from_root = [](double root) { return std::copysign(root * root, root); };
  Eigen::Matrix3d full = covariance;
  full(0, 1) = full(1, 0) = from_root(ne_eu_un[0]);
  full(1, 2) = full(2, 1) = -from_root(ne_eu_un[1]);
  full(0, 2) = full(2, 0) = -from_root(ne_eu_un[2]);
  if (Eigen::LLT<Eigen::Matrix3d>(full).info() == Eigen::Success) covariance = full;
}

std::string take_position(std::span<const double> v, GnssFix& fix) {
  if (std::string fault = to_geodetic(triple(v, 0), fix.position); !fault.empty()) return fault;
  Eigen::Vector3d sigma = triple(v, 3);
  if (std::isnan(sigma[0])) sigma = {v[16] / std::sqrt(2.0), v[16] / std::sqrt(2.0), v[17]};
  if (sigma.hasNaN()) return {};
  if (!(sigma.minCoeff() > 0.0) || !sigma.allFinite())
    return "a standard deviation is not positive";
  fix.position_covariance_ned_m2 = variances(sigma);
  add_covariances(triple(v, 6), fix.position_covariance_ned_m2);
  return {};
}

std::string take_velocity(std::span<const double> v, GnssFix& fix) {
  Eigen::Vector3d velocity = triple(v, 9);
  if (std::isnan(velocity[2])) velocity[2] = -v[15];
  Eigen::Vector3d sigma = triple(v, 12);
  if (sigma.hasNaN()) sigma.setConstant(std::isnan(v[20]) ? 0.3 : v[20]);
  if (std::isnan(velocity[0]) && v[18] >= 0.0 && std::isfinite(v[19])) {
    velocity.head<2>() = v[18] * Eigen::Vector2d(std::cos(v[19]), std::sin(v[19]));
    velocity[2] = 0.0;
    sigma[2] = std::hypot(sigma[2], 0.05 * v[18]);  // a slope of three degrees
  }
  if (velocity.hasNaN()) return {};
  if (!velocity.allFinite()) return "the velocity is not finite";
  if (!(sigma.minCoeff() > 0.0) || !sigma.allFinite())
    return "a standard deviation of the velocity is not positive";
  fix.velocity_ned_mps = velocity;
  fix.velocity_covariance_ned = variances(sigma);
  return {};
}

}  // namespace

Result<FixFile> parse_fixes(std::string_view all, const std::string& source,
                            const ColumnFormat& format) {
  const auto rows =
      ColumnRows::open(all, source, rtklib_columns(all, format).value_or(format), kFix);
  if (!rows) return rows.error();
  if (auto present = rows->require(0, 3); !present) return present.error();
  FixFile file;
  const auto take = [&](const ColumnRow& row) -> std::string {
    GnssFix fix;
    fix.time = row.time;
    if (std::string fault = take_position(row.numbers, fix); !fault.empty()) return fault;
    if (std::string fault = take_velocity(row.numbers, fix); !fault.empty()) return fault;
    const double q = row.numbers[21];
    file.fixes.push_back(std::move(fix));
    file.qualities.push_back(q >= 0.0 && q < 100.0 ? static_cast<int>(q) : 0);
    return {};
  };
  if (rows->for_each(take, file.problems) == 0) return no_content("fix", source, file.problems);
  return file;
}

Result<FixFile> read_fixes(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_fixes, format);
}

std::string format_fixes(std::span<const GnssFix> fixes) {
  std::string out =
      "t_s lat_deg lon_deg h_m sn_m se_m sd_m sne_m seu_m sun_m "
      "vn_mps ve_mps vd_mps svn_mps sve_mps svd_mps\n";
  const auto root = [](double covariance) {
    return std::copysign(std::sqrt(std::abs(covariance)), covariance);
  };
  for (const GnssFix& fix : fixes) {
    append_time(out, fix.time);
    append_position(out, fix.position);
    const Eigen::Matrix3d& p = fix.position_covariance_ned_m2;
    append_numbers(out, p.diagonal().cwiseSqrt().eval());
    append_numbers(out, std::array{root(p(0, 1)), root(-p(1, 2)), root(-p(0, 2))});
    const Eigen::Vector3d unknown =
        Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    append_numbers(out, fix.velocity_ned_mps.value_or(unknown));
    append_numbers(out, fix.velocity_covariance_ned.diagonal().cwiseSqrt().eval());
    out += '\n';
  }
  return out;
}

}  // namespace wayfare::io
