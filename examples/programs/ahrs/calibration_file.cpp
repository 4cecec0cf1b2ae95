#include "calibration_file.hpp"

#include <cstddef>

#include <nlohmann/json.hpp>

namespace wayfare::examples {
namespace {

using Json = nlohmann::json;

template <class Matrix>
Json rows_of(const Matrix& m) {
  Json rows = Json::array();
  for (int r = 0; r < m.rows(); ++r) {
    Json row = Json::array();
    for (int c = 0; c < m.cols(); ++c) row.push_back(m(r, c));
    rows.push_back(m.cols() == 1 ? row[0] : row);
  }
  return rows;
}

/// Three finite numbers.
bool read_triple(const Json& from, Eigen::Vector3d& to) {
  if (!from.is_array() || from.size() != 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!from[i].is_number()) return false;
    to[static_cast<Eigen::Index>(i)] = from[i].get<double>();
  }
  return to.allFinite();
}

}  // namespace

Result<MagnetometerCalibration> read_calibration(const std::string& path) {
  const auto content = io::read_file(path);
  if (!content) return content.error();
  const Json json = Json::parse(content->bytes, nullptr, false);
  const auto error = [&](const char* what) { return Error{ErrorCode::parse, what, path}; };
  if (!json.is_object()) return error("is not a JSON object");
  MagnetometerCalibration c;
  if (!json.contains("offset_uT") || !read_triple(json["offset_uT"], c.offset_uT))
    return error("needs 'offset_uT', three numbers");
  const bool square = json.contains("correction") && json["correction"].is_array() &&
                      json["correction"].size() == 3;
  for (std::size_t r = 0; r < 3; ++r) {
    Eigen::Vector3d row;
    if (!square || !read_triple(json["correction"][r], row))
      return error("needs 'correction', three rows of three numbers");
    c.correction.row(static_cast<Eigen::Index>(r)) = row.transpose();
  }
  return c;
}

Result<void> write_calibration(const std::string& path, const MagnetometerCalibration& c,
                               const io::WriteOptions& options) {
  const Json json{{"offset_uT", rows_of(c.offset_uT)},
                  {"correction", rows_of(c.correction)},
                  {"offset_sigma_uT", rows_of(c.offset_sigma_uT)},
                  {"correction_sigma", rows_of(c.correction_sigma)},
                  {"field_uT", c.field_uT},
                  {"residual_uT", c.residual_uT},
                  {"raw_residual_uT", c.raw_residual_uT},
                  {"readings", c.used}};
  return io::write_file(path, json.dump(2) + "\n", options);
}

}  // namespace wayfare::examples
