module bw_plan
  !! The plan of a tolerance: the aim, the survey of modes, and the expected errors of their sum. Unused with given counts.
  use bw_kinds, only: dp
  use bw_mode_survey, only: mode_survey
  use bw_piece_beam, only: piece_beam
  use bw_truncation_error, only: lowest_cutoff, phase_agreement
  implicit none (type, external)
  private

  integer, parameter, public :: looked_ahead = 4096   !! count up to which twice as many modes are surveyed as are summed
  real(dp), parameter, public :: bound_times = 100.0_dp    !! a proved bound may be so many tolerances
  real(dp), parameter :: known = 0.95_dp     !! aim once a sum has shown the cancellation in blocks
  real(dp), parameter :: least_kept = 0.02_dp !! least share of a tolerance left to omitted modes by phase errors

  type, public :: plan_type
    real(dp) :: tolerance = 0.0_dp           !! of the peak; 0: counts are given
    real(dp) :: peak = 0.0_dp                !! largest displacement with few modes or in the last sum, V l²/h
    real(dp) :: aim = 0.8_dp                 !! part of the tolerance used to choose counts before phases are known
    real(dp), allocatable :: part(:, :) !! |sum of a block| over the sum of its amplitudes with fewer modes, (points, segments)
    type(mode_survey), allocatable :: survey(:)   !! modes of each segment; unallocated: counts are given
    logical, allocatable :: exhausted(:)     !! there are no more modes, (segments)
    logical :: within = .true.               !! as far as is known, the tolerance can be met
    real(dp) :: reached = 0.0_dp             !! expected displacement error over the peak
    real(dp) :: surely = 0.0_dp              !! the same with all modes there are, for any phases
    real(dp) :: drift = 0.0_dp               !! part of it due to rounding of frequencies under tension
  contains
    procedure :: begin
    procedure :: allowed
    procedure :: take_segment
    procedure :: part_of_block
    procedure :: is_certain
    procedure :: learn
    procedure :: named
  end type plan_type

contains

  subroutine begin(self, tolerance, segments)
    !! Reset the plan. Survey and results of sums are kept, also for another tolerance.
    class(plan_type), intent(inout) :: self
    real(dp), intent(in) :: tolerance
    integer, intent(in) :: segments          !! upper limit
    self%tolerance = tolerance
    self%within = .true.
    self%reached = 0.0_dp
    self%surely = 0.0_dp
    self%drift = 0.0_dp
    if (allocated(self%exhausted)) deallocate (self%exhausted)
    allocate (self%exhausted(segments), source=.false.)
    if (.not. allocated(self%survey)) allocate (self%survey(segments))
  end subroutine begin

  elemental real(dp) function allowed(self, drift)
    !! Return the error allowed for omitted modes, V l²/h.
    class(plan_type), intent(in) :: self
    real(dp), intent(in) :: drift            !! phase errors, V l²/h
    allowed = self%aim*max(self%tolerance*self%peak - drift, least_kept*self%tolerance*self%peak)
  end function allowed

  pure subroutine take_segment(self, i, error, surely, drift, exhausted)
    !! Record the expected errors of the modes chosen for a segment, V l²/h.
    class(plan_type), intent(inout) :: self
    integer, intent(in) :: i                 !! of the segment
    real(dp), intent(in) :: error, surely    !! due to omitted modes: expected, and proved with all modes there may be
    real(dp), intent(in) :: drift            !! due to phases
    logical, intent(in) :: exhausted         !! there are no more modes
    self%reached = max(self%reached, (error + drift)/self%peak)
    self%surely = max(self%surely, (surely + drift)/self%peak)
    self%drift = max(self%drift, drift/self%peak)
    self%exhausted(i) = exhausted
  end subroutine take_segment

  pure function part_of_block(self, i, count, samples, beam) result(part)
    !! Return the ratio |sum| to sum of amplitudes expected of a block of a segment's modes, (points): that of random
    !! phases; for modes with little dispersion that of the modes below; and at least that in a sum of fewer modes.
    class(plan_type), intent(in) :: self
    integer, intent(in) :: i, count, samples
    type(piece_beam), intent(in) :: beam
    real(dp), allocatable :: part(:)
    associate (survey => self%survey(i))
      associate (dispersing => findloc(survey%bin(:survey%bins)%square <= lowest_cutoff(beam), .true., dim=1, back=.true.))
        part = phase_agreement(survey, min(count, survey%bin(max(1, dispersing))%last), samples)
      end associate
    end associate
    if (allocated(self%part)) part = max(part, self%part(:, i))
  end function part_of_block

  elemental logical function is_certain(self)
    !! Return whether more modes surely meet the tolerance, for any phases.
    class(plan_type), intent(in) :: self
    real(dp), parameter :: of_few = 0.5_dp   ! least true peak over that with few modes
    is_certain = self%tolerance <= 0.0_dp .or. self%peak <= 0.0_dp .or. self%surely <= of_few*self%tolerance
  end function is_certain

  pure subroutine learn(self, part, peak, i, error, drift)
    !! Learn from a sum that missed the tolerance: phases agree more than random ones, or the peak is smaller than with
    !! few modes. The next plan has more modes, if there are any.
    class(plan_type), intent(inout) :: self
    real(dp), allocatable, intent(inout) :: part(:, :)   !! in its blocks; used up
    integer, intent(in) :: i                             !! segment with the largest error
    real(dp), intent(in) :: peak, error, drift           !! of the sum, V l²/h
    self%peak = peak
    self%reached = error/peak
    self%surely = self%reached
    self%drift = drift/peak
    self%within = .not. self%exhausted(i)
    self%aim = merge(known*min(1.0_dp, self%tolerance/self%reached)*self%aim, known, allocated(self%part) .and. self%within)
    call move_alloc(part, self%part)
  end subroutine learn

  elemental real(dp) function named(self)
    !! Return a tolerance that can be met, with two digits.
    class(plan_type), intent(in) :: self
    real(dp), parameter :: margin = 1.02_dp
    real(dp) :: digit
    digit = 10.0_dp**(floor(log10(margin*self%surely)) - 1)
    named = digit*ceiling(margin*self%surely/digit)
  end function named

end module bw_plan
