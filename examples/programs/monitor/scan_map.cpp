#include "scan_map.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <wayfare/io/map_image.hpp>
#include <wayfare/logger/messages.hpp>

#include "support/slam_outputs.hpp"

namespace wayfare::examples {

Result<void> ScanMap::add(const io::McapReader& file, const std::string& topic, double most_s) {
  std::vector<LaserScan> scans;
  file.read({io::McapOrder::file, {topic}, read_ + Duration(1)}, [&](const io::McapMessage& m) {
    read_ = std::max(read_, m.log_time);
    if (auto scan = logger::parse_laser_scan(m.data)) scans.push_back(*std::move(scan));
    return true;
  });
  std::stable_sort(scans.begin(), scans.end(),
                   [](const LaserScan& a, const LaserScan& b) { return a.time < b.time; });
  Result<void> done = Error{ErrorCode::not_found, "there are no laser scans"};
  for (const LaserScan& scan : scans) {
    if (!first_) first_ = scan.time;
    if (scan.time > *first_ + from_seconds(most_s)) break;
    if (const auto added = slam_.add_scan(scan, {}); !added) done = added.error();
  }
  return slam_.statistics().scans > 0 ? Result<void>() : done;
}

Result<std::string> ScanMap::png(const io::McapReader& file, const std::string& topic,
                                 double most_s) {
  const std::lock_guard lock(mutex_);
  if (auto done = add(file, topic, most_s); !done) return done.error();
  if (auto done = slam_.finish(); !done) return done.error();
  return io::encode_png(map_picture(slam_.map(), slam_.trajectory()));
}

double ScanMap::cell_m() { return OccupancyGridOptions{}.resolution_m; }

}  // namespace wayfare::examples
