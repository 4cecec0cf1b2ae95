#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/xbus.hpp>

#include "tables.hpp"

namespace wayfare::examples {

namespace {

using decode::MtGnss;

constexpr std::string_view kGnssNames =
    "message,itow_ms,year,month,day,hour,minute,second,nano_ns,valid,fix,flags,satellites,lat_deg,"
    "lon_deg,h_ellipsoid_m,h_msl_m,horizontal_accuracy_m,vertical_accuracy_m,time_accuracy_ns,"
    "vn_mps,ve_mps,vd_mps,ground_speed_mps,course_deg,speed_accuracy_mps,course_accuracy_deg,"
    "heading_deg,gdop,pdop,tdop,vdop,hdop,ndop,edop";

std::string_view names_of(XsensTable table) {
  if (table == XsensTable::gnss) return kGnssNames;
  if (table == XsensTable::satellites) return "message,itow_ms,system,satellite,cn0_dbhz,flags";
  return "message,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,temperature_c,"
         "gyro_x_temperature_c,gyro_y_temperature_c,gyro_z_temperature_c";
}

void add(Csv& csv, const MtGnss& g) {
  csv.field(g.itow_ms).field(g.utc.year).field(g.utc.month).field(g.utc.day).field(g.utc.hour);
  csv.field(g.utc.minute).field(g.utc.second).field(g.nano).field(g.utc.flags).field(g.fix);
  csv.field(g.flags).field(g.satellites);
  csv.field(1e-7 * g.latitude_e7_deg).field(1e-7 * g.longitude_e7_deg);
  for (const double mm : {double(g.height_mm), double(g.height_msl_mm),
                          double(g.horizontal_accuracy_mm), double(g.vertical_accuracy_mm)})
    csv.field(1e-3 * mm);
  csv.field(g.time_accuracy_ns);
  for (const std::int32_t v : g.velocity_ned_mmps) csv.field(1e-3 * v);
  csv.field(1e-3 * g.ground_speed_mmps).field(1e-5 * g.heading_of_motion_e5_deg);
  csv.field(1e-3 * g.speed_accuracy_mmps).field(1e-5 * g.heading_accuracy_e5_deg);
  csv.field(1e-5 * g.heading_e5_deg);
  for (const std::uint16_t dop : g.dop_e2) csv.field(0.01 * dop);
}

void add(Csv& csv, const decode::MtRawReadings& readings) {
  if (readings.counts) {
    for (const auto* v : {&readings.counts->accelerometer, &readings.counts->gyroscope,
                          &readings.counts->magnetometer})
      for (int i = 0; i < 3; ++i) csv.field((*v)[i]);
    csv.field(readings.temperature_c.value_or(0.0));
  } else {
    csv.empty(10);
  }
  for (int i = 0; i < 3; ++i)
    readings.gyro_temperature_c ? csv.field((*readings.gyro_temperature_c)[i]) : csv.empty();
}

}  // namespace

Table xsens_other_table(decode::Bytes capture, XsensTable table) {
  Csv csv(names_of(table));
  std::size_t index = 0, rows = 0;
  const auto row = [&]() -> Csv& {
    ++rows;
    return csv.row().field(index);
  };
  const auto statistics =
      decode_all<decode::XbusDecoder>(capture, [&](const decode::XbusMessage& m) {
        ++index;
        if (m.id() != decode::XbusId::mt_data2) return;
        if (table == XsensTable::gnss) {
          const auto sample = decode::mt_sample(m.data());
          if (sample && sample->gnss) add(row(), *sample->gnss);
        } else if (table == XsensTable::satellites) {
          const auto satellites = decode::mt_satellites(m.data());
          for (std::size_t i = 0; satellites && i < satellites->size(); ++i) {
            const decode::MtSatellite s = (*satellites)[i];
            row().field(satellites->itow_ms()).field(s.system).field(s.id).field(s.cn0_dbhz);
            csv.field(s.flags);
          }
        } else {
          const auto readings = decode::mt_raw_readings(m.data());
          if (readings.counts || readings.gyro_temperature_c) add(row(), readings);
        }
      });
  return {std::move(csv).take(), statistics,
          std::to_string(index) + " messages, " + std::to_string(rows) + " rows"};
}

}  // namespace wayfare::examples
