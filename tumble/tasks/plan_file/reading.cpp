#include "tumble/tasks/plan_file/reading.hpp"

namespace tumble::plan_file {

Settings resolve_section(Reading& reading, tables::Section& section, const std::vector<Option>& options,
                         const Sentence& what, const std::vector<Given>& sets) {
  return resolve(options, overridden(section.rest(), sets), what, reading.problems.all);
}

}  // namespace tumble::plan_file
