#include "links.hpp"

#include <cmath>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/process.hpp>

// A block, a coupling and a vector measurement of one's own: the temperatures of two rooms, which a
// door lets come together, and the offset of their thermometers.
namespace {

struct Rooms {
  using Value = Eigen::Vector2d;
  static constexpr wayfare::BlockNames<2> kNames{"kitchen", "hall"};
};
struct Offset : wayfare::GaussMarkov<1> {
  static constexpr wayfare::BlockNames<1> kNames{"offset"};
};
using House = wayfare::State<Rooms, Offset>;

struct Door {
  using Moves = wayfare::BlockList<Rooms>;
  using By = wayfare::BlockList<Rooms>;
  double time_s = 100.0;
  Eigen::Vector2d moved(const Eigen::Vector2d& rooms, double dt_s) const {
    const double flow = 0.5 * (1.0 - std::exp(-dt_s / time_s)) * (rooms[1] - rooms[0]);
    return {rooms[0] + flow, rooms[1] - flow};
  }
  Eigen::Vector2d noise(const Eigen::Vector2d&, double dt_s) const {
    return Eigen::Vector2d::Constant(1e-4 * dt_s);
  }
};

struct Thermometers {
  using Blocks = wayfare::BlockList<Offset, Rooms>;
  using Jacobians = wayfare::AutomaticJacobians;
  static constexpr int kDim = 2;
  Eigen::Vector2d read;
  Eigen::Matrix2d covariance = 0.01 * Eigen::Matrix2d::Identity();
  template <class T>
  Eigen::Matrix<T, 2, 1> error(const Eigen::Matrix<T, 1, 1>& offset,
                               const Eigen::Matrix<T, 2, 1>& rooms) const {
    return rooms + Eigen::Matrix<T, 2, 1>::Constant(offset[0]) - read.cast<T>();
  }
};

}  // namespace

bool own_states() {
  using namespace wayfare;
  const Process<House, Door, Offset> process{Door{}, Offset{{0.1, 1000.0}}};
  Ekf<House> filter(House{}, Eigen::Vector3d(400.0, 400.0, 0.01).asDiagonal());
  Eigen::Vector2d truth(18.0, 24.0);
  for (int i = 0; i < 100; ++i) {
    truth = Door{}.moved(truth, 1.0);
    filter.predict(process, 1.0);
    filter.update(Thermometers{truth});
  }
  return (filter.state().get<Rooms>() - truth).norm() < 0.2 && House::names()[2] == "offset";
}
