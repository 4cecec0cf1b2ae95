#include <wayfare/nav/gnss_ins.hpp>

#include <functional>
#include <utility>

#include "nav/gnss_ins/filter.hpp"

namespace wayfare {

GnssIns::GnssIns(const GnssInsOptions& options) : filter_(detail::make_owned<Filter>(options)) {}
GnssIns::GnssIns(const GnssIns& other) : filter_(detail::make_owned<Filter>(*other.filter_)) {}
GnssIns& GnssIns::operator=(const GnssIns& other) { return *this = GnssIns(other); }

void GnssIns::start(const GnssInsStart& start) { filter_->start(start); }
bool GnssIns::started() const { return filter_->started(); }
Result<void> GnssIns::add(const ImuSample& sample) { return filter_->add(sample); }
Result<void> GnssIns::add(const RangeEpoch& epoch) { return filter_->add(epoch); }
Result<void> GnssIns::add(const GnssFix& fix) { return filter_->add(fix); }
GnssInsEstimate GnssIns::estimate() const {
  return filter_->engine().view().estimate(filter_->q_body_imu());
}
GnssInsPoint GnssIns::point() const {
  return filter_->engine().view().point(filter_->q_body_imu());
}
std::optional<GnssInsEstimate> GnssIns::lagged() const { return filter_->lagged(); }
std::string GnssIns::missing() const { return filter_->missing(); }
std::vector<InnovationRecord> GnssIns::take_innovations() {
  return std::exchange(filter_->events().innovations, {});
}
std::vector<GnssInsNotice> GnssIns::take_notices() {
  return std::exchange(filter_->events().notices, {});
}

void detail::InsHistoryAccess::keep(GnssIns& filter) {
  filter.filter_->history().open(Duration::max() / 2);
}
void detail::InsHistoryAccess::smooth(const GnssIns& filter, nav::InsAdjoint& adjoint,
                                      const std::function<void(const nav::InsView&)>& sink) {
  filter.filter_->history().back(adjoint, [&](LogTime, const auto& smoothed) {
    sink(smoothed().view());
    return true;
  });
}

}  // namespace wayfare
