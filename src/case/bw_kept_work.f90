module bw_kept_work
  !! Work that the cases of a sweep share, done once: whoever goes through the cases holds it and hands it to each. It takes
  !! a bounded amount of memory however many cases there are, and changes no bit of their results.
  use bw_amplitude_spectrum, only: spectrum_plan
  use bw_galerkin_source, only: galerkin_cache
  use bw_kept_blows, only: kept_blows
  use bw_mode_cache, only: mode_cache
  use bw_nonuniform_sum, only: nonuniform_sum
  implicit none (type, external)
  private

  type, public :: kept_work
    type(mode_cache) :: modes          !! roots and shapes by mass ratio
    type(galerkin_cache) :: operators  !! modes without a closed form
    type(kept_blows) :: blows          !! states after t = 0
    type(nonuniform_sum) :: sum        !! kernel, plan and grids of the last transform
    type(spectrum_plan) :: spectrum    !! window and plan of the last spectrum
  end type kept_work

end module bw_kept_work
