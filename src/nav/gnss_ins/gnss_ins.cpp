#include <wayfare/nav/gnss_ins.hpp>

#include <memory>
#include <utility>

#include "nav/gnss_ins/any_filter.hpp"
#include "nav/gnss_ins/filter_kinds.hpp"

namespace wayfare {

namespace nav {

std::unique_ptr<AnyInsFilter> make_ins_filter(const GnssInsOptions& options) {
  const bool aided = options.odometer || options.carrier_phase;
  return aided ? make_aided_filter(options) : make_plain_filter(options);
}

}  // namespace nav

class GnssIns::Filter {
 public:
  explicit Filter(const GnssInsOptions& options) : any_(nav::make_ins_filter(options)) {}
  Filter(const Filter& other) : any_(other.any_->copy()) {}
  Filter& operator=(const Filter&) = delete;
  ~Filter() = default;

  nav::AnyInsFilter* operator->() { return any_.get(); }
  nav::AnyInsFilter& operator*() { return *any_; }

 private:
  std::unique_ptr<nav::AnyInsFilter> any_;
};

GnssIns::GnssIns(const GnssInsOptions& options) : filter_(detail::make_owned<Filter>(options)) {}
GnssIns::GnssIns(const GnssIns& other) : filter_(detail::make_owned<Filter>(*other.filter_)) {}
GnssIns& GnssIns::operator=(const GnssIns& other) { return *this = GnssIns(other); }

void GnssIns::start(const GnssInsStart& start) { (*filter_)->start(start); }
bool GnssIns::started() const { return (*filter_)->started(); }
Result<void> GnssIns::add(const ImuSample& sample) { return (*filter_)->add(sample); }
Result<void> GnssIns::add(const RangeEpoch& epoch) { return (*filter_)->add(epoch); }
Result<void> GnssIns::add(const GnssFix& fix) { return (*filter_)->add(fix); }
Result<void> GnssIns::add(const WheelSpeed& wheels) { return (*filter_)->add(wheels); }
GnssInsEstimate GnssIns::estimate() const { return (*filter_)->estimate(); }
GnssInsPoint GnssIns::point() const { return (*filter_)->point(); }
std::optional<GnssInsEstimate> GnssIns::lagged() const { return (*filter_)->lagged(); }
std::string GnssIns::missing() const { return (*filter_)->missing(); }
std::vector<InnovationRecord> GnssIns::take_innovations() {
  return std::exchange((*filter_)->events().innovations, {});
}
std::vector<GnssInsNotice> GnssIns::take_notices() {
  return std::exchange((*filter_)->events().notices, {});
}

nav::AnyInsFilter& detail::InsHistoryAccess::filter(GnssIns& ins) { return **ins.filter_; }

}  // namespace wayfare
