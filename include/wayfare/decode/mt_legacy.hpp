#pragma once

// Xsens MTData, the predecessor of MTData2: fields without ids, in an order given by two settings.

#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/mt_sample.hpp>

namespace wayfare::decode {

/// The device's SetOutputMode and SetOutputSettings.
struct MtLegacyLayout {
  std::uint16_t mode = 0;
  std::uint32_t settings = 0;

  [[nodiscard]] MtPrecision precision() const {
    return static_cast<MtPrecision>(settings >> 8 & 3);
  }
};

/// Raw readings of the converters, uncalibrated.
struct MtRaw {
  Eigen::Matrix<std::uint16_t, 3, 1> accelerometer, gyroscope, magnetometer;
  std::uint16_t temperature = 0;
};

/// A legacy message: the calibrated parts in the same form as of MTData2.
struct MtLegacySample {
  MtSample sample;
  std::optional<MtRaw> raw;
  std::optional<std::uint16_t> aux1, aux2;
  std::optional<Eigen::Vector3d> position_lla;  ///< degrees, degrees, m
};

namespace detail {

/// Reads from the front; once anything is missing, every later read fails.
class MtCursor {
 public:
  MtCursor(Bytes data, MtPrecision precision) : data_(data), precision_(precision) {}

  [[nodiscard]] bool has_all() const { return good_; }
  [[nodiscard]] bool at_end() const { return good_ && data_.empty(); }

  Bytes next(std::size_t n) {
    good_ = good_ && n <= data_.size();
    if (!good_) return {};
    const Bytes taken = data_.first(n);
    data_ = data_.subspan(n);
    return taken;
  }
  template <class T>
  T whole() {
    const Bytes b = next(sizeof(T));
    return b.empty() ? T{} : load_be<T>(b.data());
  }
  template <int N>
  Eigen::Matrix<double, N, 1> reals() {
    Eigen::Matrix<double, N, 1> values = Eigen::Matrix<double, N, 1>::Zero();
    const std::size_t size = bytes_of(precision_);
    const Bytes b = next(N * size);
    if (b.empty()) return values;
    for (int i = 0; i < N; ++i)
      values[i] = mt_real(&b[static_cast<std::size_t>(i) * size], precision_);
    good_ = values.allFinite();
    return values;
  }

 private:
  Bytes data_;
  MtPrecision precision_;
  bool good_ = true;
};

inline void take_raw(MtCursor& in, MtLegacySample& out) {
  MtRaw raw;
  for (auto* vector : {&raw.accelerometer, &raw.gyroscope, &raw.magnetometer})
    for (int i = 0; i < 3; ++i) (*vector)[i] = in.whole<std::uint16_t>();
  raw.temperature = in.whole<std::uint16_t>();
  out.raw = raw;
}

inline void take_orientation(MtCursor& in, std::uint32_t settings, MtSample& out) {
  switch (settings & 0xC) {
    case 0x0:
      out.quaternion = in.reals<4>();
      break;
    case 0x4:
      out.euler_deg = in.reals<3>();
      break;
    default: {
      const Eigen::Matrix<double, 9, 1> columns = in.reals<9>();
      out.rotation_matrix = Eigen::Map<const Eigen::Matrix3d>(columns.data());
    }
  }
}

}  // namespace detail

/// The content of an MTData message of this layout; nullopt where its length does not match the
/// layout, or where the layout includes a receiver's raw data (mode 1000), which is not supported.
[[nodiscard]] inline std::optional<MtLegacySample> mt_legacy_sample(Bytes data,
                                                                    const MtLegacyLayout& layout) {
  const std::uint16_t mode = layout.mode;
  const std::uint32_t settings = layout.settings;
  if ((mode & 0x1000) != 0) return std::nullopt;
  detail::MtCursor in(data, layout.precision());
  MtLegacySample out;
  MtSample& s = out.sample;
  s.frame = (settings & 0x80000000U) != 0 ? MtFrame::ned : MtFrame::nwu;
  if ((mode & 0x4000) != 0) detail::take_raw(in, out);
  if ((mode & 0x0001) != 0) s.temperature_c = in.reals<1>()[0];
  if ((mode & 0x0002) != 0) {
    if ((settings & 0x10) == 0) s.acceleration_mps2 = in.reals<3>();
    if ((settings & 0x20) == 0) s.rate_radps = in.reals<3>();
    if ((settings & 0x40) == 0) s.magnetic_field_au = in.reals<3>();
  }
  if ((mode & 0x0004) != 0) detail::take_orientation(in, settings, s);
  if ((mode & 0x0008) != 0) {
    if ((settings & 0x400) == 0) out.aux1 = in.whole<std::uint16_t>();
    if ((settings & 0x800) == 0) out.aux2 = in.whole<std::uint16_t>();
  }
  if ((mode & 0x0010) != 0) out.position_lla = in.reals<3>();
  if ((mode & 0x0020) != 0) s.velocity_mps = in.reals<3>();
  if ((mode & 0x0800) != 0) s.status_byte = in.whole<std::uint8_t>();
  if ((settings & 1) != 0) s.packet_counter = in.whole<std::uint16_t>();
  if ((settings & 2) != 0) {
    const Bytes utc = in.next(12);
    if (!utc.empty()) s.utc = detail::mt_utc(utc.data());
  }
  return in.at_end() ? std::optional(out) : std::nullopt;
}

}  // namespace wayfare::decode
