#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "tumble/formats/checksum.hpp"
#include "tumble/language/texts.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/version.hpp"

namespace tumble {

namespace assets {
/// Files of the pages by name, packed by gzip; empty where they were not built.
extern const std::vector<std::pair<std::string_view, std::string_view>> pages;
}  // namespace assets

namespace routes {
namespace {

std::string unpacked(std::string_view packed) {
  z_stream stream{};
  std::string out(packed.size() * 12 + 65536, '\0');
  if (inflateInit2(&stream, 15 + 16) != Z_OK) return "";
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const bool whole = inflate(&stream, Z_FINISH) == Z_STREAM_END;
  out.resize(whole ? stream.total_out : 0);
  inflateEnd(&stream);
  return out;
}

std::string type_of_page(std::string_view name) {
  if (std::filesystem::path(name).extension() == ".html") return "text/html; charset=utf-8";
  if (std::filesystem::path(name).extension() == ".js") return "text/javascript; charset=utf-8";
  if (std::filesystem::path(name).extension() == ".css") return "text/css; charset=utf-8";
  return "application/json";
}

std::string tag_of(std::string_view bytes) { return "\"" + first_digits(sha256_of(bytes), 16) + "\""; }

HttpResponse page(const HttpRequest& request, std::string_view name) {
  const auto found = std::ranges::find(assets::pages, name, [](const auto& entry) { return entry.first; });
  if (found == assets::pages.end())
    return {404, "text/plain; charset=utf-8",
            "This program was built without the pages of the workbench: esbuild was missing (Debian: esbuild).\n"};
  HttpResponse response;
  response.type = type_of_page(name);
  const std::string tag = tag_of(found->second);
  response.headers = {{"Cache-Control", "no-cache"}, {"ETag", tag}, {"Vary", "Accept-Encoding"}};
  const auto known = request.headers.find("if-none-match");
  if (known != request.headers.end() && known->second == tag) {
    response.status = 304;
    return response;
  }
  const auto accepts = request.headers.find("accept-encoding");
  if (accepts != request.headers.end() && accepts->second.find("gzip") != std::string::npos) {
    response.headers.emplace_back("Content-Encoding", "gzip");
    response.body = std::string(found->second);
  } else {
    response.body = unpacked(found->second);
  }
  return response;
}

HttpResponse index(Context&, const HttpRequest& request) { return page(request, "index.html"); }
HttpResponse script(Context&, const HttpRequest& request) { return page(request, "app.js"); }
HttpResponse style(Context&, const HttpRequest& request) { return page(request, "app.css"); }
HttpResponse description(Context&, const HttpRequest& request) { return page(request, "openapi.json"); }

HttpResponse texts(Context&, const HttpRequest& request) {
  required(request, "language");
  return json_response(texts_of(language_asked(request), "web"));
}

HttpResponse workbench(Context& context, const HttpRequest&) {
  return json_response({{"program", "tumble"},
                        {"version", version},
                        {"folder", context.options.folder.filename().string()},
                        {"languages", language_codes()},
                        {"archive", !context.options.archive.empty()},
                        {"upload_limit", context.options.upload_limit}});
}

}  // namespace

std::vector<Route> page_routes() {
  return {{.method = "GET", .path = "/", .answer = index, .open = true},
          {.method = "GET", .path = "/archive", .answer = index, .open = true},
          {.method = "GET", .path = "/station", .answer = index, .open = true},
          {.method = "GET", .path = "/results", .answer = index, .open = true},
          {.method = "GET", .path = "/plans", .answer = index, .open = true},
          {.method = "GET", .path = "/app.js", .answer = script, .open = true},
          {.method = "GET", .path = "/app.css", .answer = style, .open = true},
          {.method = "GET", .path = "/openapi.json", .answer = description, .open = true},
          {.method = "GET", .path = "/api/texts", .answer = texts, .open = true},
          {"GET", "/api/workbench", workbench}};
}

}  // namespace routes
}  // namespace tumble
