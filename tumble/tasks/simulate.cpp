#include "tumble/tasks/tasks.hpp"

namespace tumble {

void simulate_to(const std::string& path, const Plan& plan, std::uint64_t seed, std::size_t memory,
                 const Progress& progress) {
  format_to_write(path);  // a target that cannot be written is refused before the simulation, not after it
  constexpr std::size_t block = std::size_t{1} << 20;  ///< samples a channel
  if (simulated_size(plan) < memory) return write_recording(simulate(plan, seed, progress), path);
  const RecordingWriter writer = recording_writer(path);
  simulate(plan, seed, block, writer.append, progress);
  writer.commit();
}

}  // namespace tumble
