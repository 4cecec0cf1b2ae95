#pragma once

// Snapshots of Xsens MTw trackers (Awinda) in order, and the motion between them.
//
// A tracker integrates its rate and acceleration and sends the integrals, so that lost packets cost
// resolution, not motion. The message format is not published; the scales were found from
// recordings and agree with the maker's export to the last digit printed.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/decode/detail/mt_values.hpp>

namespace wayfare::decode {

/// A tracker's integrals at the end of a frame, in the units of the message.
struct AwindaSnapshot {
  std::uint32_t device = 0;    ///< id of the tracker
  std::uint32_t frame = 0;     ///< one for each sample period, of all trackers of a station
  bool retransmitted = false;  ///< late, and perhaps after later ones
  std::array<std::int32_t, 3> orientation{};  ///< 2^-31: three components of a unit quaternion
  std::array<std::int32_t, 3> velocity{};     ///< 2^-16 m/s, modulo 2^28
  std::array<std::int16_t, 3> field{};        ///< 2^-12 of the Earth's field where calibrated
  std::uint32_t pressure = 0;                 ///< of the air; its unit is not known
  /// Bits 0 to 2, 3 to 5, 6 to 8: an axis of acceleration, rate, field is clipped; 9: the field is
  /// new; 11, 12: the component of the orientation that is omitted.
  std::uint16_t status = 0;
  std::uint8_t clipped_acceleration = 0,  ///< counter of the tracker
      clipped_rate = 0;                   ///< counter of the tracker
  std::optional<std::int8_t> rssi_dbm;    ///< signal strength at the station

  /// From the tracker's axes to those at the start of integration. The largest component is
  /// omitted; the status contains its index.
  [[nodiscard]] Eigen::Quaterniond integrated_orientation() const {
    const unsigned omitted = status >> 11 & 3U;
    std::array<double, 4> q{};
    double rest = 1.0;
    for (unsigned i = 0; i < 3; ++i) {
      const double component = orientation[i] * 0x1p-31;
      q[(omitted + 1 + i) % 4] = component;
      rest -= component * component;
    }
    q[omitted] = std::sqrt(std::max(0.0, rest));
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }
  /// In units of the Earth's field.
  [[nodiscard]] Eigen::Vector3d field_au() const {
    return Eigen::Vector3d(field[0], field[1], field[2]) / 4096.0;
  }
};

/// The snapshot in an MTData2 message of a station, with its signal strength, if there is one.
[[nodiscard]] inline std::optional<AwindaSnapshot> awinda_snapshot(Bytes data) {
  std::optional<AwindaSnapshot> found;
  std::optional<std::int8_t> rssi;
  const bool whole = for_each_mt_packet(data, [&](const MtPacket& p) {
    if (p.id == 0xE040) rssi = p.whole<std::int8_t>();
    if ((p.id != 0xC810 && p.id != 0xC811) || p.data.size() != 46) return;
    const std::uint8_t* b = p.data.data();
    AwindaSnapshot s;
    s.device = load_be<std::uint32_t>(b);
    s.frame = load_be<std::uint32_t>(b + 4);
    s.retransmitted = p.id == 0xC811;
    for (std::size_t i = 0; i < 3; ++i) {
      s.orientation[i] = load_be<std::int32_t>(b + 8 + 4 * i);
      s.velocity[i] = load_be<std::int32_t>(b + 20 + 4 * i);
      s.field[i] = load_be<std::int16_t>(b + 32 + 2 * i);
    }
    s.pressure = load_be<std::uint32_t>(b + 38);
    s.status = load_be<std::uint16_t>(b + 42);
    s.clipped_acceleration = b[44];
    s.clipped_rate = b[45];
    found = s;
  });
  if (!whole || !found) return std::nullopt;
  found->rssi_dbm = rssi;
  return found;
}

/// Mean rate and specific force between two snapshots, in the tracker's axes at the first.
struct AwindaMotion {
  std::uint32_t device = 0;  ///< id of the tracker
  std::uint32_t frame = 0;   ///< of the later snapshot
  std::uint32_t frames = 0;  ///< between the two; more than 1 bridges lost ones
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  ///< specific force
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();         ///< mean
  /// Of the later snapshot, in units of the Earth's field.
  Eigen::Vector3d field_au = Eigen::Vector3d::Zero();
  std::uint16_t status = 0;  ///< of the later snapshot
};

namespace detail {

/// The difference of two numbers known modulo 2^28.
[[nodiscard]] constexpr std::int32_t wrapped_28(std::int32_t later, std::int32_t earlier) {
  const auto difference = static_cast<std::uint32_t>(later) - static_cast<std::uint32_t>(earlier);
  return static_cast<std::int32_t>(difference << 4) >> 4;
}

/// J_l(θ)⁻¹ v of SO(3): removes the effect of the rotation θ during which v was accumulated (Sola
/// et al. 2018, eq. 146).
[[nodiscard]] inline Eigen::Vector3d without_rotation(const Eigen::Vector3d& theta,
                                                      const Eigen::Vector3d& v) {
  const double square = theta.squaredNorm(), half = 0.5 * std::sqrt(square);
  const double k =
      square < 1e-6 ? 1.0 / 12.0 + square / 720.0 : (1.0 - half / std::tan(half)) / square;
  return v - 0.5 * theta.cross(v) + k * theta.cross(theta.cross(v));
}

}  // namespace detail

/// Motion from `a` to a later snapshot `b` of the same tracker; `period_s` is the frame period. Not
/// finite where no time is between them: equal frames, a period of zero.
[[nodiscard]] inline AwindaMotion awinda_motion(const AwindaSnapshot& a, const AwindaSnapshot& b,
                                                double period_s) {
  AwindaMotion m{b.device, b.frame, b.frame - a.frame, {}, {}, b.field_au(), b.status};
  const double duration_s = period_s * m.frames;
  const Eigen::Quaterniond qa = a.integrated_orientation(), qb = b.integrated_orientation();
  Eigen::Quaterniond rotation = qa.conjugate() * qb;
  if (rotation.w() < 0.0) rotation.coeffs() *= -1.0;
  const Eigen::Vector3d theta = SO3d(rotation.normalized()).log();
  Eigen::Vector3d delta_v;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    delta_v[i] = detail::wrapped_28(b.velocity[k], a.velocity[k]) * 0x1p-16;
  }
  m.rate_radps = theta / duration_s;
  m.acceleration_mps2 = detail::without_rotation(theta, qa.conjugate() * delta_v) / duration_s;
  return m;
}

/// A station's configuration message (0D): its id and those of its trackers.
struct AwindaConfiguration {
  std::uint32_t station = 0;   ///< its id
  double period_s = 0.0;       ///< of the station's clock, in units of 1/115200 s; 0: not given
  std::uint16_t trackers = 0;  ///< number of them
  Bytes data;                  ///< of the message; must outlive this

  /// Id of a tracker.
  [[nodiscard]] std::uint32_t tracker(std::size_t i) const {
    WAYFARE_EXPECTS(i < trackers, "there is no such tracker");
    return load_be<std::uint32_t>(&data[98 + 20 * i]);
  }
};

/// Of the data of message 0D; nullopt where its length does not match the number of trackers.
[[nodiscard]] inline std::optional<AwindaConfiguration> awinda_configuration(Bytes data) {
  if (data.size() < 98) return std::nullopt;
  AwindaConfiguration c{load_be<std::uint32_t>(data.data()),
                        load_be<std::uint16_t>(&data[4]) / 115200.0,
                        load_be<std::uint16_t>(&data[96]), data};
  if (data.size() != 98 + std::size_t{20} * c.trackers) return std::nullopt;
  return c;
}

/// Sorts one tracker's snapshots by frame. A missing one is dropped after `kWindow` frames. A jump
/// by more than twice as many begins another sequence: what is buffered is delivered before. A jump
/// back does so unless it is a retransmission, which is late: a counter that restarted, or the
/// frame after one with a damaged number.
template <std::size_t kWindow = 32>
class AwindaReorderBuffer {
 public:
  /// Takes a snapshot and passes those now in order to `sink(const AwindaSnapshot&)`.
  template <class Sink>
  void add(const AwindaSnapshot& snapshot, Sink&& sink) {
    if (!std::exchange(started_, true)) next_ = snapshot.frame;
    const std::int64_t ahead = static_cast<std::int32_t>(snapshot.frame - next_);  // wraps around
    constexpr std::int64_t kJump = 2 * kWindow;
    const bool restarted = ahead >= kJump || (ahead <= -kJump && !snapshot.retransmitted);
    if (!restarted && (ahead < 0 || buffered(snapshot.frame))) {
      ++late_;
      return;
    }
    if (restarted) {
      finish(sink);
      started_ = true;
      next_ = snapshot.frame;
    }
    while (snapshot.frame - next_ >= kWindow) step(sink);
    slots_[snapshot.frame % kWindow] = {snapshot, true};
    while (slots_[next_ % kWindow].full) step(sink);
  }

  /// Delivers the snapshots still buffered.
  template <class Sink>
  void finish(Sink&& sink) {
    for (std::size_t i = 0; i < kWindow && started_; ++i) {
      Slot& slot = slots_[(next_ + i) % kWindow];
      if (slot.full) sink(static_cast<const AwindaSnapshot&>(slot.snapshot));
      slot.full = false;
    }
    started_ = false;
  }

  [[nodiscard]] std::uint64_t late() const { return late_; }        ///< late or duplicate
  [[nodiscard]] std::uint64_t missing() const { return missing_; }  ///< dropped

 private:
  struct Slot {
    AwindaSnapshot snapshot;
    bool full = false;
  };
  static_assert((kWindow & (kWindow - 1)) == 0, "the window must be a power of two");

  [[nodiscard]] bool buffered(std::uint32_t frame) const {
    const Slot& slot = slots_[frame % kWindow];
    return slot.full && slot.snapshot.frame == frame;
  }
  template <class Sink>
  void step(Sink& sink) {
    Slot& slot = slots_[next_ % kWindow];
    if (slot.full) {
      sink(static_cast<const AwindaSnapshot&>(slot.snapshot));
    } else {
      ++missing_;
    }
    slot.full = false;
    ++next_;
  }

  std::array<Slot, kWindow> slots_{};
  std::uint32_t next_ = 0;
  bool started_ = false;
  std::uint64_t late_ = 0, missing_ = 0;
};

/// The trackers of a station: takes snapshots in any order, delivers ordered motions. Across a step
/// back of the frame counter there is none.
template <std::size_t kTrackers = 32, std::size_t kWindow = 32>
class AwindaStation {
 public:
  /// `period_s`: the frame period, from the station's output rate. Where it is not positive and
  /// finite, as in a damaged configuration, all snapshots are refused.
  explicit AwindaStation(double period_s) : period_s_(period_s) {}

  /// Calls `sink(const AwindaMotion&)`.
  template <class Sink>
  void add(const AwindaSnapshot& snapshot, Sink&& sink) {
    const bool measurable = period_s_ > 0.0 && std::isfinite(period_s_);
    Tracker* tracker = measurable ? find(snapshot.device) : nullptr;
    if (tracker == nullptr) {
      ++refused_;
      return;
    }
    tracker->order.add(snapshot, [&](const AwindaSnapshot& s) { follow(*tracker, s, sink); });
  }
  /// Delivers the motions of the snapshots still buffered.
  template <class Sink>
  void finish(Sink&& sink) {
    for (std::size_t i = 0; i < trackers_; ++i) {
      Tracker& tracker = all_[i];
      tracker.order.finish([&](const AwindaSnapshot& s) { follow(tracker, s, sink); });
      tracker.has_previous = false;
    }
  }

  /// Number of trackers seen.
  [[nodiscard]] std::size_t trackers() const { return trackers_; }
  /// Snapshots of trackers beyond `kTrackers`, or without a valid period.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }
  /// Snapshots of all trackers that were late or duplicate.
  [[nodiscard]] std::uint64_t late() const {
    std::uint64_t sum = 0;
    for (const Tracker& tracker : all_) sum += tracker.order.late();
    return sum;
  }
  /// Frames of all trackers that were dropped.
  [[nodiscard]] std::uint64_t missing() const {
    std::uint64_t sum = 0;
    for (const Tracker& tracker : all_) sum += tracker.order.missing();
    return sum;
  }

 private:
  struct Tracker {
    std::uint32_t device = 0;
    bool has_previous = false;
    AwindaSnapshot previous;
    AwindaReorderBuffer<kWindow> order;
  };

  Tracker* find(std::uint32_t device) {
    for (std::size_t i = 0; i < trackers_; ++i)
      if (all_[i].device == device) return &all_[i];
    if (trackers_ == kTrackers) return nullptr;
    all_[trackers_].device = device;
    return &all_[trackers_++];
  }
  template <class Sink>
  void follow(Tracker& tracker, const AwindaSnapshot& s, Sink& sink) {
    const auto frames = static_cast<std::int32_t>(s.frame - tracker.previous.frame);
    if (tracker.has_previous && frames > 0) sink(awinda_motion(tracker.previous, s, period_s_));
    tracker.previous = s;
    tracker.has_previous = true;
  }

  double period_s_;
  std::array<Tracker, kTrackers> all_{};
  std::size_t trackers_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace wayfare::decode
