#pragma once

#include <string>
#include <unordered_map>
#include <unordered_set>

namespace tumble::file {

/// Names of which each is given once: where a file has "ax" twice, the second one is "ax_2".
class UniqueNames {
 public:
  std::string take(const std::string& written);

 private:
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, std::size_t> last_;  ///< [1] number that was given last, by the name as written
};

}  // namespace tumble::file
