module bw_plan
  !! How many modes a tolerance takes, as it is found: what is aimed at, what is known of the modes, and what is expected of their
  !! sum. Of counts that a scene gives nothing is planned.
  use bw_kinds, only: dp
  use bw_mode_survey, only: mode_survey
  use bw_piece_beam, only: piece_beam
  use bw_truncation_error, only: agree_beyond, part_shown
  implicit none (type, external)
  private

  integer, parameter, public :: looked_ahead = 4096   !! modes up to whose number twice as many are surveyed as are summed
  real(dp), parameter, public :: bound_times = 100.0_dp    !! a tolerance, that is proved
  real(dp), parameter :: known = 0.95_dp     !! aim once a sum has shown what blocks come to
  real(dp), parameter :: least_kept = 0.02_dp   !! of a tolerance, that is left to missing modes where phases take more than all of it

  type, public :: plan_type
    real(dp) :: tolerance = 0.0_dp           !! part of the peak; 0: counts are given
    real(dp) :: peak = 0.0_dp                !! largest displacement, as few modes show it or a sum of fewer has, V l²/h
    real(dp) :: aim = 0.8_dp                 !! part of the tolerance by which counts are chosen: phases are not known yet
    real(dp), allocatable :: part(:, :)      !! of the sum of its amplitudes that a block of a sum of fewer came to, (points, segments)
    type(mode_survey), allocatable :: survey(:)   !! of the modes of each segment; unallocated: counts are given
    logical, allocatable :: exhausted(:)     !! there are no more modes, (segments)
    logical :: within = .true.               !! the tolerance can be kept, for all that is known
    real(dp) :: reached = 0.0_dp             !! expected error of the displacement over the peak
    real(dp) :: surely = 0.0_dp              !! what it would be of all modes there are, whatever their phases
    real(dp) :: drift = 0.0_dp               !! the part of that which the rounding of frequencies under tension has
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
    !! Forget what was chosen. The survey and what sums have shown serve on, of the same tolerance or another.
    class(plan_type), intent(inout) :: self
    real(dp), intent(in) :: tolerance
    integer, intent(in) :: segments          !! at most
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
    !! What modes that are missing may add, V l²/h.
    class(plan_type), intent(in) :: self
    real(dp), intent(in) :: drift            !! of phases, V l²/h
    allowed = self%aim*max(self%tolerance*self%peak - drift, least_kept*self%tolerance*self%peak)
  end function allowed

  pure subroutine take_segment(self, i, error, surely, drift, exhausted)
    !! Take in what is expected of the modes that were chosen for a segment, V l²/h.
    class(plan_type), intent(inout) :: self
    integer, intent(in) :: i                 !! of the segment
    real(dp), intent(in) :: error, surely    !! of missing modes: expected, and proved of all that there may be
    real(dp), intent(in) :: drift            !! of phases
    logical, intent(in) :: exhausted         !! there are no more
    self%reached = max(self%reached, (error + drift)/self%peak)
    self%surely = max(self%surely, (surely + drift)/self%peak)
    self%drift = max(self%drift, drift/self%peak)
    self%exhausted(i) = exhausted
  end subroutine take_segment

  pure function part_of_block(self, i, count, samples, beam) result(part)
    !! Of the sum of its amplitudes, that a block of a segment's modes comes to: what it would with random phases, of modes whose waves
    !! hardly disperse no less than of those below, or what a sum of fewer showed, (points).
    class(plan_type), intent(in) :: self
    integer, intent(in) :: i, count, samples
    type(piece_beam), intent(in) :: beam
    real(dp), allocatable :: part(:)
    associate (survey => self%survey(i))
      associate (dispersing => findloc(survey%bin(:survey%bins)%square <= agree_beyond(beam), .true., dim=1, back=.true.))
        part = part_shown(survey, min(count, survey%bin(max(1, dispersing))%last), samples)
      end associate
    end associate
    if (allocated(self%part)) part = max(part, self%part(:, i))
  end function part_of_block

  elemental logical function is_certain(self)
    !! The tolerance is kept whatever phases are, if not by the modes that were chosen then by more.
    class(plan_type), intent(in) :: self
    real(dp), parameter :: of_few = 0.5_dp   ! of a peak as few modes show it, that there is at least
    is_certain = self%tolerance <= 0.0_dp .or. self%peak <= 0.0_dp .or. self%surely <= of_few*self%tolerance
  end function is_certain

  pure subroutine learn(self, part, peak, i, error, drift)
    !! A sum misses the tolerance: phases agree more than random ones do, or the peak is smaller than few modes showed it. The next plan
    !! has more modes, unless there are none.
    class(plan_type), intent(inout) :: self
    real(dp), allocatable, intent(inout) :: part(:, :)   !! that its blocks came to; used up
    integer, intent(in) :: i                             !! segment whose error is the largest
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
    !! A tolerance that can be kept, in two digits.
    class(plan_type), intent(in) :: self
    real(dp), parameter :: margin = 1.02_dp
    real(dp) :: digit
    digit = 10.0_dp**(floor(log10(margin*self%surely)) - 1)
    named = digit*ceiling(margin*self%surely/digit)
  end function named

end module bw_plan
