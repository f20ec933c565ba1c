#include "played_rig.hpp"

#include "wall_clock.hpp"

namespace tumble::cli {

PlayedRig::PlayedRig(const Plan& plan, const Station& station, double speed, std::uint64_t seed)
    : station_(station), parts_(parts_of(station_)), bench_(plan, station_, parts_, seed, {}) {
  bench_.put(mounted_for(plan, station_));
  const double begin = wall_time();
  server_.emplace(
      bench_, station_, [begin, speed] { return speed * (wall_time() - begin); }, speed);
  thread_ = std::thread([this] { server_->serve(ended_); });
}

PlayedRig::~PlayedRig() {
  ended_ = true;
  thread_.join();
}

}  // namespace tumble::cli
