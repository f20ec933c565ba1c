#include "tumble/station/recorder_read.hpp"

#include "tumble/station/recorder/visit.hpp"

namespace tumble {

StoreContent visit_store(const std::string& run, const std::function<void(const StoreItem&)>& visit) {
  const std::string path = recorder::path_of_store(run);
  Disk disk;
  const recorder::StoreFile store = recorder::open_store(path, disk);
  try {
    StoreContent content = recorder::describe(store);
    recorder::visit(store, content, visit);
    return content;
  } catch (const recorder::Refusal& refusal) {
    recorder::refuse_to_read(path, refusal);
  }
}

}  // namespace tumble
