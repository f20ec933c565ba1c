#include "tumble/math/fourier.hpp"

#define POCKETFFT_NO_MULTITHREADING
#define POCKETFFT_CACHE_SIZE 4  // plans of lengths used again and again
#include <pocketfft/pocketfft_hdronly.h>

namespace tumble {

void real_transform(std::span<const double> x, std::vector<std::complex<double>>& spectrum) {
  spectrum.resize(x.size() / 2 + 1);
  pocketfft::r2c<double>({x.size()}, {sizeof(double)}, {sizeof(std::complex<double>)}, 0, true, x.data(),
                         spectrum.data(), 1.0);
}

}  // namespace tumble
