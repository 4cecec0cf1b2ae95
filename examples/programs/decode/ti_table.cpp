#include <cmath>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/io/text_file.hpp>

#include "tables.hpp"

namespace wayfare::examples {

namespace {

void add_point(const decode::TiFrame& frame, std::size_t i, const std::string& time,
               std::optional<double> doppler_step_mps, Csv& csv) {
  const decode::TiPoint p = frame[i];
  csv.row().field(frame.header().frame_number).field(time).field(i);
  csv.field(p.x_m).field(p.y_m).field(p.z_m);
  if (!std::isnan(p.doppler_mps)) {
    csv.field(p.doppler_mps);
  } else if (doppler_step_mps) {
    csv.field(*doppler_step_mps * p.doppler_bin);
  } else {
    csv.empty();
  }
  frame.has_strength() ? csv.field(p.snr_ddb / 10.0) : csv.empty();
  frame.has_noise() ? csv.field(p.noise_ddb / 10.0) : csv.empty();
  if (frame.encoding() == decode::TiPoints::fixed) {
    csv.field(p.range_bin).field(p.doppler_bin).field(p.peak);
  } else {
    csv.empty(3);
  }
}

}  // namespace

Table ti_table(decode::Bytes capture, std::optional<double> doppler_step_mps) {
  Csv csv(
      "frame,sensor_t_s,point,x_m,y_m,z_m,doppler_mps,snr_db,noise_db,range_bin,doppler_bin,peak");
  decode::TiClock clock;
  std::size_t points = 0;
  const auto decoder = std::make_unique<decode::TiDecoder>();
  const auto take = [&](const decode::TiFrame& frame) {
    const std::string time = frame.header().has_clock()
                                 ? io::format_nanoseconds(clock.at(frame.header()).nanoseconds())
                                 : std::string();
    for (std::size_t i = 0; i < frame.size(); ++i) add_point(frame, i, time, doppler_step_mps, csv);
    points += frame.size();
  };
  decoder->feed(capture, take);
  decoder->finish(take);
  const decode::DecoderStatistics& statistics = decoder->statistics();
  return {std::move(csv).take(), statistics,
          std::to_string(statistics.frames) + " frames with " + std::to_string(points) + " points",
          to_string(decoder->framing().refusal())};
}

}  // namespace wayfare::examples
