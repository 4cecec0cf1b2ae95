#include <algorithm>
#include <cmath>

#include <wayfare/logger/device_decoder.hpp>

namespace wayfare::logger {
namespace {

/// Damaged counters may add up to a time from which differences overflow.
Time<DeviceClock> device_time(double since_s) {
  constexpr double kFarthest_s = 1e9;
  return Time<DeviceClock>::from_seconds(std::clamp(since_s, -kFarthest_s, kFarthest_s));
}

}  // namespace

void XsensStream::feed(decode::Bytes bytes, LogTime arrived, const Sink& sink,
                       const StateSink& states) {
  fed_ += bytes.size();
  decoder_.feed(bytes, [&](const decode::XbusMessage& message) {
    const std::uint64_t end = message.position() + message.bytes().size();
    const LogTime sent = arrived - decode::line_time(fed_ - end + message.bytes().size(), baud_);
    take(message, sent, sink, states);
  });
}

void XsensStream::take(const decode::XbusMessage& message, LogTime sent, const Sink& sink,
                       const StateSink& states) {
  if (message.id() == decode::XbusId::configuration) {
    // A station sends its rate once; before, or if that is missed, 100 Hz.
    if (const auto c = decode::awinda_configuration(message.data()); c && c->period_s > 0.0)
      begin(c->period_s);
    return;
  }
  if (message.id() != decode::XbusId::mt_data2) return;
  if (const auto snapshot = decode::awinda_snapshot(message.data())) {
    if (!station_) begin(0.01);
    take(*snapshot, sent, sink, states);
  } else if (const auto sample = decode::mt_sample(message.data())) {
    const LogTime time = take(*sample, sent, sink);
    if (!states) return;
    const MtState state = mt_state(message.data(), *sample, time);
    if (state.has_content()) states(std::nullopt, state);
  }
}

void XsensStream::begin(double period_s) {
  period_s_ = period_s;
  station_ = std::make_unique<decode::AwindaStation<>>(period_s);
  frames_ = decode::CounterUnwrapper(std::uint64_t{1} << 32);
}

void XsensStream::take(const decode::AwindaSnapshot& snapshot, LogTime sent, const Sink& sink,
                       const StateSink& states) {
  // A retransmission is late by more than the line's delay; its frame counter gives its time.
  const auto device = [&](std::uint32_t frame) {
    return device_time(static_cast<double>(frames_.at(frame)) * period_s_);
  };
  if (!snapshot.retransmitted) envelope_.add(device(snapshot.frame), sent);
  const std::uint64_t refused = station_->refused();
  station_->add(snapshot, [&](const decode::AwindaMotion& motion) {
    sink(motion.device, decode::to_marg_sample(motion, envelope_(device(motion.frame))));
  });
  if (!states || station_->refused() != refused) return;
  MtState state;
  state.time = envelope_(device(snapshot.frame));
  state.sample.frame_counter = snapshot.frame;
  state.sample.status_word = snapshot.status;
  state.sample.rssi_dbm = snapshot.rssi_dbm;
  const Eigen::Quaterniond q = snapshot.integrated_orientation();
  state.sample.quaternion = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
  if (snapshot.pressure != 0) state.sample.pressure_pa = snapshot.pressure;
  states(snapshot.device, state);
}

LogTime XsensStream::take(const decode::MtSample& sample, LogTime sent, const Sink& sink) {
  LogTime time = sent;
  if (sample.sample_time_fine)
    time = envelope_.add(
        device_time(1e-4 * static_cast<double>(fine_.at(*sample.sample_time_fine))), sent);
  const MargSample marg = decode::to_marg_sample(sample, time);
  if (marg.angular_rate_radps.allFinite() || marg.specific_force_mps2.allFinite())
    sink(std::nullopt, marg);
  return time;
}

}  // namespace wayfare::logger
