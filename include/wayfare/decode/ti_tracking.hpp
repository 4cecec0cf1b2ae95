#pragma once

// What TI's people counting, area scanner and xWRL demos report besides points: targets, their
// heights, the points that belong to them, presence, vital signs. Layouts: TI, user's guides of the
// mmWave Industrial Toolbox 4.7 (3D people counting, area scanner) and parseTLVs.py of the Radar
// Toolbox. No capture of them is at hand: they are tested against encoders of these layouts.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/ti_frame.hpp>

namespace wayfare::decode {

/// A tracked target: x right, y forward, z up.
struct TiTarget {
  std::uint32_t id = 0;                      ///< of the track
  std::array<float, 3> position_m{};         ///< of its centre
  std::array<float, 3> velocity_mps{};       ///< of its centre
  std::array<float, 3> acceleration_mps2{};  ///< of its centre
  float gain = TiPoint::kNone;               ///< of the gate; NaN where not sent
  float confidence = TiPoint::kNone;         ///< 0 to 1; NaN where not sent
};

/// The targets of a frame. Refers to the frame's bytes.
class TiTargets {
 public:
  TiTargets() = default;
  /// `payload` in entries of `stride` bytes: 112 (3D), 72 or 68 (in a plane), 40 (area scanner).
  TiTargets(Bytes payload, std::size_t stride) : payload_(payload), stride_(stride) {}

  /// Number of targets.
  [[nodiscard]] std::size_t size() const { return payload_.size() / stride_; }
  /// Target i < size().
  [[nodiscard]] TiTarget operator[](std::size_t i) const {
    const auto real = [&](std::size_t k) { return load_le<float>(&payload_[stride_ * i + 4 * k]); };
    TiTarget t;
    t.id = load_le<std::uint32_t>(&payload_[stride_ * i]);
    if (stride_ == 112) {
      t.position_m = {real(1), real(2), real(3)};
      t.velocity_mps = {real(4), real(5), real(6)};
      t.acceleration_mps2 = {real(7), real(8), real(9)};
      t.gain = real(26);
      t.confidence = real(27);
      return t;
    }
    const bool area = stride_ == 40;
    t.position_m = {real(1), real(2), area ? real(7) : 0.0F};
    t.velocity_mps = {real(3), real(4), area ? real(8) : 0.0F};
    t.acceleration_mps2 = {real(5), real(6), area ? real(9) : 0.0F};
    if (!area) t.gain = real(16);
    if (stride_ == 72) t.confidence = real(17);
    return t;
  }

 private:
  Bytes payload_;
  std::size_t stride_ = 112;
};

/// Vertical extent of a target.
struct TiTargetHeight {
  std::uint32_t id = 0;  ///< of the track
  float top_m = 0.0F,    ///< highest point
      bottom_m = 0.0F;   ///< lowest point
};

/// Breathing and heart beat of one person.
struct TiVitalSigns {
  std::uint16_t id = 0,                    ///< of the person
      range_bin = 0;                       ///< where the chest is
  float breath_deviation = 0.0F,           ///< of the breathing; 0: holds the breath
      heart_per_min = 0.0F,                ///< rate
      breath_per_min = 0.0F;               ///< rate
  std::array<float, 15> heart_waveform{},  ///< of the last frames
      breath_waveform{};                   ///< of the last frames
};

namespace detail {

/// The payload of the item that has this content, by the numbers of the frame's layout.
[[nodiscard]] inline Bytes ti_item(const TiFrame& frame, std::uint32_t area, std::uint32_t tracker,
                                   TiTlv lab, TiTlv packed) {
  const TiLayout layout = frame.header().layout;
  if (layout == TiLayout::area_scanner) return frame.find(static_cast<TiTlv>(area));
  if (layout != TiLayout::demo) return frame.find(static_cast<TiTlv>(tracker));
  const Bytes found = frame.find(lab);
  return found.empty() ? frame.find(packed) : found;
}

}  // namespace detail

/// The targets of a frame; none where their length is of no known layout.
[[nodiscard]] inline TiTargets ti_targets(const TiFrame& frame) {
  const Bytes b = detail::ti_item(frame, 10, 7, TiTlv::targets, TiTlv::packed_targets);
  const TiLayout layout = frame.header().layout;
  std::size_t stride = layout == TiLayout::area_scanner ? 40 : 112;
  if (layout == TiLayout::tracker_2d) stride = b.size() % 68 == 0 ? 68 : 72;
  return b.size() % stride == 0 ? TiTargets(b, stride) : TiTargets();
}

/// For each point of the frame before, the target it belongs to; 253: too weak, 254: out of the
/// zone, 255: noise.
[[nodiscard]] inline Bytes ti_target_index(const TiFrame& frame) {
  return detail::ti_item(frame, 11, 8, TiTlv::target_index, TiTlv::packed_target_index);
}

/// Number of target heights, and one of them.
[[nodiscard]] inline std::size_t ti_height_count(const TiFrame& frame) {
  return frame.find(TiTlv::target_heights).size() / 12;
}
/// Height i < ti_height_count().
[[nodiscard]] inline TiTargetHeight ti_height(const TiFrame& frame, std::size_t i) {
  const Bytes b = frame.find(TiTlv::target_heights).subspan(12 * i, 12);
  return {load_le<std::uint32_t>(b.data()), load_le<float>(&b[4]), load_le<float>(&b[8])};
}

/// Whether anyone is in the zone; nullopt where it is not sent.
[[nodiscard]] inline std::optional<bool> ti_presence(const TiFrame& frame) {
  const bool tracker = frame.header().counts_item_heads();
  constexpr auto kOfTracker = static_cast<TiTlv>(11);
  const Bytes b = frame.find(tracker ? kOfTracker : TiTlv::presence);
  if (b.size() != 4) return std::nullopt;
  return load_le<std::uint32_t>(b.data()) != 0;
}

/// The vital signs; nullopt where they are not sent.
[[nodiscard]] inline std::optional<TiVitalSigns> ti_vital_signs(const TiFrame& frame) {
  const Bytes b = frame.find(TiTlv::vital_signs);
  if (b.size() != 136) return std::nullopt;
  const auto real = [&](std::size_t k) { return load_le<float>(&b[4 + 4 * k]); };
  TiVitalSigns v{load_le<std::uint16_t>(b.data()),
                 load_le<std::uint16_t>(&b[2]),
                 real(0),
                 real(1),
                 real(2),
                 {},
                 {}};
  for (std::size_t i = 0; i < 15; ++i) {
    v.heart_waveform[i] = real(3 + i);
    v.breath_waveform[i] = real(18 + i);
  }
  return v;
}

}  // namespace wayfare::decode
