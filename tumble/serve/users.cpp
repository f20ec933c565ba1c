#include "tumble/serve/users.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/passwords.hpp"
#include "tumble/tasks/plan_edit.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using tables::FileProblems;
using tables::Section;

constexpr std::size_t longest_name = 100;  ///< bytes

std::set<Right> roles_in(Section& section) {
  std::set<Right> roles;
  for (const auto& word : section.texts("roles")) {
    const auto found = std::ranges::find_if(all_rights(), [&](Right right) { return name(right) == word; });
    if (found == all_rights().end())
      section.problem_at("roles", say("'{}' is no role: read, operate or approve is expected", word));
    else
      roles.insert(*found);
  }
  return roles;
}

User user_in(Section& section) {
  User user{section.text("name").value_or(""), roles_in(section), section.text("password").value_or("")};
  if (!section.find("name"))
    section.missing("name", "\"Li Wei\"");
  else if (user.name.empty() || user.name.size() > longest_name || !is_plain_name(user.name) ||
           user.name.front() == ' ' || user.name.back() == ' ')
    section.problem_at("name", say("a name of 1 to {} bytes is expected", longest_name));
  if (!section.find("roles")) section.missing("roles", "[\"read\", \"operate\"]");
  if (!section.find("password"))
    section.problem("the password is missing: tumble serve --users FILE --password-of NAME");
  else if (!is_password_hash(user.password))
    section.problem_at("password",
                       "this is not what is kept of a password; tumble serve --users FILE --password-of "
                       "NAME writes it");
  return user;
}

std::vector<User> users_of(const std::string& text, const std::string& path) {
  const auto document = tables::document_of(text, path);
  FileProblems problems{.file = path, .all = {}};
  Section root(document, "", problems);
  std::vector<User> users;
  const auto* list = root.find("user");
  const auto* array = list ? list->as_array() : nullptr;
  if (list && !array) root.problem_at("user", "a list is expected: [[user]]");
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    const auto* table = (*array)[i].as_table();
    if (!table) {
      root.problem_at("user", "a list of tables is expected: [[user]]");
      continue;
    }
    Section section(*table, "[[user]]", problems);
    User user = user_in(section);
    if (std::ranges::find(users, user.name, &User::name) != users.end())
      section.problem_at("name", say("'{}' is there twice", user.name));
    section.close();
    users.push_back(std::move(user));
  }
  root.close();
  if (!problems.all.empty()) throw Error(Error::Kind::bad_input, problems.sorted());
  return users;
}

/// Who may write the file may become any user.
void require_private(const std::string& path) {
  struct stat state {};
  if (stat(path.c_str(), &state) == 0 && (state.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    throw Error{Error::Kind::bad_file,
                say("{}: others may write this file of users: chmod 600 {}", Name{path}, Name{path})};
}

std::string entry_of(const User& user) {
  std::vector<std::string> roles;
  for (const Right right : user.roles) roles.push_back(toml_text(name(right)));
  return fmt::format("[[user]]\nname = {}\nroles = [{}]\npassword = {}\n", toml_text(user.name), fmt::join(roles, ", "),
                     toml_text(user.password));
}

void write_private(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  chmod(file.temporary().c_str(), S_IRUSR | S_IWUSR);
  file.write(text);
  file.commit();
}

}  // namespace

std::vector<User> read_users(const std::string& path) {
  require_private(path);
  return users_of(read_text_file(path), path);
}

void add_user(const std::string& path, const User& user) {
  std::error_code failed;
  const bool there = std::filesystem::exists(path, failed);
  std::string text =
      there ? read_text_file(path) : "# Users of a workbench: tumble serve --users FILE --add-user NAME --role ROLE\n";
  if (there) require_private(path);
  if (!text.empty() && text.back() != '\n') text += '\n';
  text += "\n" + entry_of(user);
  users_of(text, path);
  write_private(path, text);
}

void change_password(const std::string& path, const std::string& user, const std::string& hash) {
  const auto users = read_users(path);
  const auto found = std::ranges::find(users, user, &User::name);
  if (found == users.end()) throw Error{Error::Kind::bad_input, say("{}: there is no user '{}'", Name{path}, user)};
  const PlanPath place{"user", std::to_string(found - users.begin()), "password"};
  write_private(path, with_value(read_text_file(path), path, place, toml_text(hash)));
}

}  // namespace tumble
