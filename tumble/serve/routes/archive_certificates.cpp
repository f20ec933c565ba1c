#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tumble/archive/history.hpp"
#include "tumble/archive/signatures.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/temporary_folder.hpp"
#include "tumble/language/said.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/archive.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/tasks/certificate.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::routes {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_listed = 1000;
constexpr std::uintmax_t largest_lab = 1'000'000;  ///< bytes

/// What replaces keys of the laboratory's file: one list for the preview and for the command line.
Sets sets_of_certificate(const Context& context, const std::string& number, const std::string& rule,
                         const std::string& language) {
  Sets sets;
  if (!number.empty()) sets.emplace_back("certificate.number", number);
  if (!rule.empty()) sets.emplace_back("certificate.rule", rule);
  if (!language.empty()) sets.emplace_back("certificate.language", language);
  if (!context.options.archive.empty()) sets.emplace_back("certificate.signatures", "archive");
  return sets;
}

/// The certificate of a result, of the folder or of the archive, as `tumble certificate` makes it.
Certificate made_from(const Context& context, const HttpRequest& request) {
  const auto lab = required(request, "lab");
  CertificateDetails details =
      load_lab(existing(context, lab), sets_of_certificate(context, optional(request, "number"),
                                                           optional(request, "rule"), optional(request, "language")));
  details.file = lab;  // in messages: as its user knows it
  if (const auto digits = optional(request, "sha256"); !digits.empty()) {
    const Archive archive = archive_of(context);
    const TemporaryFolder scratch;
    const auto path = (scratch.path() / "result.json").string();
    const auto sha256 = find_result(archive, digits);
    write_file_atomically(path, result_text(archive, sha256));
    Certificate certificate = certificate_on(path, details);
    certificate.result_file = first_digits(sha256) + ".json";
    return certificate;
  }
  const auto file = required(request, "result");
  Certificate certificate = certificate_on(existing(context, file), details);
  certificate.result_file = file;
  return certificate;
}

/// Problems name files as their user knows them: from the folder on.
Certificate previewed(const Context& context, const HttpRequest& request) {
  try {
    return made_from(context, request);
  } catch (Error& error) {
    for (auto& problem : error.problems) problem = named_from(context.options.folder.string(), problem);
    throw;
  }
}

/// What its author should look at, before the page is shown: all that is missing comes as one answer.
HttpResponse preview(Context& context, const HttpRequest& request) {
  const Certificate certificate = previewed(context, request);
  std::vector<std::string> notes;
  for (const Sentence& note : certificate.notes) notes.push_back(in_language(language_asked(request), note));
  return json_response({{"notes", notes},
                        {"number", certificate.details.number},
                        {"result", certificate.result_sha256},
                        {"specimen", certificate.estimate.provenance.seed.has_value()}});
}

HttpResponse preview_page(Context& context, const HttpRequest& request) {
  return sandboxed("text/html; charset=utf-8", certificate_html(previewed(context, request)));
}

/// Writes the certificate, and puts it into the archive with its result: a job, so that its file is kept.
HttpResponse issue(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto file = text_in(body, "result"), lab = text_in(body, "lab");
  archive_of(context);
  Job job;
  job.kind = "certificate";
  job.title = file;
  Job::Step step{"certificate", existing(context, file),
                 "--lab",       existing(context, lab),
                 "--quiet",     "--by=" + person_of(context, request)};
  for (const auto& [key, value] :
       sets_of_certificate(context, text_in(body, "number"), text_in(body, "rule"), text_in(body, "language")))
    step.push_back("--set=" + key + "=" + value);
  step.insert(step.end(), {"-o", "{folder}/certificate.html"});
  job.steps = {std::move(step)};
  return started(context, request, std::move(job));
}

/// Whether a file begins as a result does.
bool begins_as_result(const fs::path& path) {
  std::string head(2048, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.find("\"method\"") != std::string::npos;
}

/// Results, files of laboratories and pages of the folder, for forms: names only, the newest first.
HttpResponse candidates(Context& context, const HttpRequest&) {
  struct Named {
    std::string name;
    fs::file_time_type changed;
  };
  std::vector<Named> results, labs, certificates;
  std::error_code failed;
  fs::recursive_directory_iterator place(context.options.folder, fs::directory_options::skip_permission_denied, failed);
  for (; !failed && place != fs::recursive_directory_iterator(); place.increment(failed)) {
    const auto& path = place->path();
    const auto name = fs::relative(path, context.options.folder, failed).generic_string();
    if (is_hidden(path) || place.depth() > 3) place.disable_recursion_pending();
    if (place->is_symlink(failed) || !place->is_regular_file(failed) || !is_plain_name(name) ||
        path.filename() == "job.json")
      continue;
    const Named one{name, place->last_write_time(failed)};
    if (path.extension() == ".json" && results.size() < most_listed && begins_as_result(path)) results.push_back(one);
    const bool page = path.extension() == ".html" || path.extension() == ".xml";
    if (page && certificates.size() < most_listed) certificates.push_back(one);
    if (path.extension() != ".toml" || labs.size() == most_listed || place->file_size(failed) > largest_lab) continue;
    try {
      if (toml::parse(read_text_file(path.string())).contains("laboratory")) labs.push_back(one);
    } catch (const std::exception&) {
      continue;  // it is no file of a laboratory
    }
  }
  Json answer;
  for (auto [key, list] :
       {std::pair{"results", &results}, std::pair{"labs", &labs}, std::pair{"certificates", &certificates}}) {
    std::ranges::sort(*list, [](const Named& a, const Named& b) {
      return a.changed != b.changed ? a.changed > b.changed : a.name < b.name;
    });
    answer[key] = Json::array();
    for (const auto& one : *list) answer[key].push_back(one.name);
  }
  return json_response(answer);
}

/// A certificate or result that the archive keeps, with the bytes that were signed.
HttpResponse kept(Context& context, const HttpRequest& request) {
  const Archive archive = archive_of(context);
  const SignedThing thing = find_signable(archive, required(request, "sha256"));
  if (thing.kind.empty()) throw Error{Error::Kind::unsupported, "the archive has no such result or certificate"};
  if (thing.kind == "result") return sandboxed("application/json", result_text(archive, thing.sha256));
  const TemporaryFolder scratch;
  const auto path = (scratch.path() / "certificate").string();
  write_stored(archive, thing.sha256, path);
  const auto text = read_text_file(path);
  return sandboxed(text.starts_with("<?xml") ? "application/xml" : "text/html; charset=utf-8", text);
}

/// Whether a file of the folder is what was signed: a signature is of bytes, not of a name.
HttpResponse compare(Context& context, const HttpRequest& request) {
  const auto file = required(request, "file");
  const auto sha256 = sha256_of_file(existing(context, file));
  const Archive archive = archive_of(context);
  const SignedThing thing = find_signable(archive, sha256);
  Json signatures = Json::array();
  if (!thing.kind.empty())
    for (const auto& one : signatures_of(archive, thing.unit))
      if (one.sha256 == sha256)
        signatures.push_back({{"meaning", one.meaning}, {"by", one.who}, {"time", one.when}, {"problem", one.problem}});
  return json_response({{"file", file},
                        {"sha256", sha256},
                        {"archived", thing.kind},
                        {"same", sha256 == optional(request, "sha256")},
                        {"signatures", signatures}});
}

}  // namespace

std::vector<Route> archive_certificate_routes() {
  constexpr std::uint64_t small = 1 << 14;
  return {{"GET", "/api/archive/candidates", candidates},
          {"GET", "/api/archive/certificate", preview},
          {"GET", "/api/archive/certificate/page", preview_page},
          {"GET", "/api/archive/kept", kept},
          {"GET", "/api/archive/compare", compare},
          {.method = "POST",
           .path = "/api/archive/certificate",
           .answer = issue,
           .body_limit = small,
           .role = Right::approve}};
}

}  // namespace tumble::routes
