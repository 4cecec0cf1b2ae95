#include "nav/gnss_ins/filter.hpp"
#include "nav/gnss_ins/filter_kinds.hpp"

namespace wayfare::nav {

std::unique_ptr<AnyInsFilter> make_aided_filter(const GnssInsOptions& options) {
  return std::make_unique<InsFilterWith<ins::Odometer<double>, ins::EarlierAntenna<double>>>(
      options);
}

}  // namespace wayfare::nav
