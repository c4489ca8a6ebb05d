module bw_found_lines
  !! What the search of a record's lines has found so far: lines, what they leave, and what was refused.
  use bw_common_noise, only: mixture_type
  use bw_damped_line, only: damped_line
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band
  use bw_ordinates, only: ordinates_type
  use bw_tapered_residual, only: residual_type
  use bw_whitening, only: no_whitening, whitening_type
  implicit none (type, external)
  private
  public :: find_nothing

  real(dp), parameter, public :: far_above = 4     !! times the threshold, what no colour of the noise does
  real(dp), parameter, public :: drift_reach = 3   !! bins; the ordinates of a drift are below half of what it gains

  integer, parameter, public :: not_needed = 1, too_broad = 2, beside_drift = 3, uncertain = 4, &
                                 noise_colour = 5

  type, public :: rejected_line
    !! A candidate that is no line.
    real(dp) :: frequency = 0                    !! periods per step
    real(dp) :: ordinate = 0                     !! what it takes off half the squares over the noise's level; of one that a
                                                 !! fit has taken elsewhere, the ordinate at the peak, which is that of a steady line
    integer :: reason = 0
    real(dp) :: sought = -1                      !! frequency of the peak that was taken for it; negative: none
  end type rejected_line

  type, public :: found_lines
    !! The lines of a record by ascending frequency.
    type(damped_line), allocatable :: lines(:)
    real(dp), allocatable :: still(:, :)         !! offset and slope over half the record, about its middle, (2, S)
    type(line_band), allocatable :: bands(:)
    real(dp) :: highest = huge(1.0_dp)           !! sample, as the length of a vector of all sensors
    real(dp) :: work = 0                         !! numbers of lines' images that have been computed
    logical :: at_rest = .true.                  !! .false.: the search was given up, and what is left may be no noise
    type(ordinates_type) :: ordinates            !! what the lines leave
    type(rejected_line), allocatable :: rejected(:)
    type(whitening_type), allocatable :: whitening(:)  !! what the samples, and with them the amplitudes, went through, (S)
    type(residual_type) :: left                  !! what the lines of a record that is known to be pure leave of it
    real(dp), allocatable :: deviation(:)        !! of what the lines leave of the record as it was, (S)
    type(mixture_type) :: mixture                !! of the sensors, whose noise is not independent; lines are those of its parts
    real(dp) :: unsteady = 0                     !! part of a sensor's squares that is neither lines nor steady noise
    logical, allocatable :: own(:)               !! the sensor is neither constant nor a multiple of one before it, (S)
  end type found_lines

contains

  pure subroutine find_nothing(sensors, found)
    !! What a search has found before it begins.
    integer, intent(in) :: sensors
    type(found_lines), intent(out) :: found
    allocate (found%lines(0), found%rejected(0))
    allocate (found%still(2, sensors), source=0.0_dp)
    found%whitening = no_whitening(sensors)
  end subroutine find_nothing

end module bw_found_lines
