module bw_measured_notes
  !! This module says in words what a reader of measured waves must know.
  use bw_kinds, only: dp
  use bw_line_peaks, only: peak_type
  use bw_mode_check, only: is_folded, is_none, measuring_type, not_known, verdict_type
  use bw_mode_curve, only: mode_type
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: measured_notes

  integer, parameter :: most_listed = 10           !! frequencies in a note
  real(dp), parameter :: worth_a_note = 1.0e-6_dp  !! growth over the record

contains

  pure function measured_notes(peaks, modes, verdict, listed, faint, told, samples) result(notes)
    !! The notes on a measurement, one for each kind of thing found.
    type(peak_type), intent(in) :: peaks(:)
    type(mode_type), intent(in) :: modes(:)
    type(verdict_type), intent(in) :: verdict(:)
    integer, intent(in) :: listed(:)           !! peaks in the result
    integer, intent(in) :: faint               !! groups left out because the residual or rounding explains them
    type(measuring_type), intent(in) :: told
    integer, intent(in) :: samples
    type(string), allocatable :: notes(:)
    logical, dimension(size(peaks)) :: folded, stray, shown
    allocate (notes(0))
    folded = verdict%kind == is_folded .and. peaks%located
    if (any(folded)) call append(notes, 'folded back from above half the sampling rate ('// &
      & shortest(samples/(2*told%duration), 6)//' Hz) and left out: modes '//ranges(pack(verdict%number, folded)))
    stray = verdict%kind == is_none .or. (verdict%kind == not_known .and. any(modes%number > 0) .and. modes%number == 0 &
      & .and. peaks%members == 1 .and. .not. peaks%at_edge)
    stray = stray .and. peaks%located
    shown = peaks%located .and. .not. (folded .or. stray)
    if (told%uniform .and. all(modes%number == 0) .and. size(peaks) > 0) call append(notes, &
      & 'the peaks cannot be numbered as modes: wave numbers and velocities are missing')
    if (any(shown .and. verdict%kind == not_known) .and. all(modes%number == 0)) call append(notes, &
      & 'nothing tells which lines are folded back from above half the sampling rate')
    if (.not. all(peaks%located)) call append(notes, 'lines that could not be told apart, left out: '// &
      & frequencies(.not. peaks%located))
    if (faint > 0) call append(notes, 'groups of lines that do not stand out of what the fit leaves, left out: '// &
      & text_of(faint))
    if (any(stray)) call append(notes, 'lines that fit no mode, left out: '//frequencies(stray))
    if (any(shown .and. peaks%members > 1)) call append(notes, &
      & 'lines closer than 1/duration, each group taken as one: '//frequencies(shown .and. peaks%members > 1))
    if (any(shown .and. peaks%at_edge)) call append(notes, &
      & 'lines at 0 or at half the sampling rate, known to 1/duration only: '//frequencies(shown .and. peaks%at_edge))
    if (any(shown .and. abs(peaks%growth) > worth_a_note)) call append(notes, &
      & 'lines that grow or decay: '//frequencies(shown .and. abs(peaks%growth) > worth_a_note))
    if (size(listed) < count(shown)) call append(notes, &
      & 'only the '//text_of(size(listed))//' strongest peaks are listed')

  contains

    pure function frequencies(chosen) result(words)
      !! The frequencies of the chosen peaks as `12.5, 80 Hz`, with `and 7 more` after the first ten.
      logical, intent(in) :: chosen(:)
      character(:), allocatable :: words
      type(string), allocatable :: frequency(:)
      integer :: j
      allocate (frequency(0))
      do j = 1, size(chosen)
        if (chosen(j) .and. size(frequency) < most_listed) then
          call append(frequency, shortest(peaks(j)%position/told%duration, 6))
        end if
      end do
      words = list(frequency)//' Hz'
      if (count(chosen) > size(frequency)) words = words//' and '//text_of(count(chosen) - size(frequency))//' more'
    end function frequencies

  end function measured_notes

  pure function ranges(numbers) result(words)
    !! The positive numbers in ascending order, as `22 to 25, 40`.
    integer, intent(in) :: numbers(:)
    character(:), allocatable :: words
    integer :: first, last
    words = ''
    last = 0
    do
      first = minval(numbers, mask=numbers > last)
      if (first == huge(first)) exit
      last = first
      do while (any(numbers == last + 1))
        last = last + 1
      end do
      if (len(words) > 0) words = words//', '
      words = words//text_of(first)
      if (last > first) words = words//' to '//text_of(last)
    end do
  end function ranges

  pure function list(items) result(words)
    !! The items, separated by commas.
    type(string), intent(in) :: items(:)
    character(:), allocatable :: words
    integer :: i
    words = ''
    do i = 1, size(items)
      if (i > 1) words = words//', '
      words = words//items(i)%text
    end do
  end function list

end module bw_measured_notes
