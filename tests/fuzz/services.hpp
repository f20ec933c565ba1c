#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tumble::fuzz {

/// Text of a station file: read, or refused with its problems.
std::string run_station(std::string_view bytes);

/// A request to the workbench over a folder with a result, a plan and a recording: the first byte chooses the route, the
/// first line behind it is the query, the rest is the body. Whatever comes, the answer is no failure of the server.
std::string run_route(std::string_view bytes);

/// The bytes of an archive's database: it is listed, read and verified, or refused.
std::string run_archive(std::string_view bytes, const std::string& path);

std::vector<std::string> seeds_of_routes();
std::vector<std::string> seeds_of_archives(const std::string& path);

}  // namespace tumble::fuzz
