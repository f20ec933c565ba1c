#pragma once

#include <map>
#include <string>
#include <vector>

namespace tumble {

/// An object of a JSON document that is being written, as Node is one that is being read. Keys keep the order in which
/// they are written.
class JsonObject {
 public:
  /// `json` points to an nlohmann::ordered_json that outlives the object.
  explicit JsonObject(void* json) : json_(json) {}

  void number(const char* key, double value) const;                        ///< [as given]; null where it is not finite
  void numbers(const char* key, const std::vector<double>& values) const;  ///< [n, as given]
  void whole(const char* key, unsigned long long value) const;
  void flag(const char* key, bool value) const;
  void text(const char* key, const std::string& value) const;
  void texts(const char* key, const std::vector<std::string>& values) const;
  void lists(const char* key, const std::vector<std::vector<std::string>>& values) const;
  void null(const char* key) const;
  /// A value that is JSON already. Throws nlohmann::json::exception where it is not.
  void json(const char* key, const std::string& text) const;
  /// A member that is an object, to be filled before the next key is written.
  JsonObject object(const char* key) const;
  /// A member that is an array of so many objects, to be filled before the next key is written.
  std::vector<JsonObject> objects(const char* key, std::size_t count) const;

 private:
  void* json_;  ///< headers do not name the library
};

}  // namespace tumble
