# Headers that most files include, compiled once a target. They are the standard library's and fmt's: none of our own,
# so that an edit does not recompile everything. Every file still includes what it uses; -DTUMBLE_PCH=OFF shows that.
set(tumble_library_headers
    <algorithm> <array> <cmath> <complex> <cstddef> <cstdint> <functional> <limits> <map> <memory> <numbers> <numeric>
    <optional> <set> <span> <string> <string_view> <tuple> <utility> <variant> <vector> <fmt/format.h> <fmt/ranges.h>)
set(tumble_program_headers ${tumble_library_headers} <filesystem>)
set(tumble_test_headers ${tumble_library_headers} <filesystem> <fstream> <random> <sstream> <gtest/gtest.h>)

function(tumble_precompile target)
  if(TUMBLE_PCH)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()
