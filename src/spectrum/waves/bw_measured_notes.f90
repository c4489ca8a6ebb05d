module bw_measured_notes
  !! This module writes the notes on measured waves.
  use bw_kinds, only: dp
  use bw_line_peaks, only: peak_type
  use bw_mode_check, only: is_alias, is_none, record_facts, not_known, verdict_type
  use bw_note, only: remark
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: measured_notes

  integer, parameter :: most_listed = 10           !! frequencies listed in a note
  integer, parameter :: most_ranges = 4            !! ranges of mode numbers in a note
  real(dp), parameter :: worth_a_note = 1.0e-6_dp  !! exponent of growth or decay over the record

contains

  pure function measured_notes(peaks, is_wave, verdict, listed, facts, samples) result(notes)
    !! The notes on a measurement, one for each kind of finding.
    type(peak_type), intent(in) :: peaks(:)
    logical, intent(in) :: is_wave(:)          !! the peak has a wave number
    type(verdict_type), intent(in) :: verdict(:)
    integer, intent(in) :: listed(:)           !! peaks in the result
    type(record_facts), intent(in) :: facts
    integer, intent(in) :: samples
    type(string), allocatable :: notes(:)
    character(:), allocatable :: left_out
    logical, dimension(size(peaks)) :: aliased, stray, shown
    allocate (notes(0))
    aliased = verdict%kind == is_alias .and. peaks%located
    stray = verdict%kind == is_none .or. (verdict%kind == not_known .and. any(is_wave) .and. .not. is_wave &
      & .and. peaks%members == 1 .and. .not. peaks%at_edge)
    stray = stray .and. peaks%located
    shown = peaks%located .and. .not. (aliased .or. stray)
    if (facts%ends == '' .and. any(shown)) call remark(notes, 'measured waves: frequencies alone are given, since '// &
      & 'Eqs 18 and 20 do not hold for this motion')
    if (facts%ends /= '' .and. .not. any(is_wave) .and. size(peaks) > 0) call remark(notes, &
      & 'measured waves: the peaks cannot be numbered as modes, so wave numbers and velocities are missing')
    left_out = left_out_text()
    if (left_out /= '') call remark(notes, 'left out of the measured peaks: '//left_out)
    if (any(shown .and. peaks%members > 1)) call remark(notes, &
      & 'close lines: closer than 1/duration, each group taken as one peak: '//frequencies(shown .and. peaks%members > 1))
    if (any(shown .and. peaks%at_edge)) call remark(notes, &
      & 'lines at 0 or at half the sampling rate: known to 1/duration only: '//frequencies(shown .and. peaks%at_edge))
    if (size(listed) < count(shown)) call remark(notes, 'max_peaks: of '//text_of(count(shown))//' peaks the '// &
      & text_of(size(listed))//' strongest are listed')
    if (allocated(facts%known)) return          ! known modes include aliasing, growth and decay
    if (any(shown .and. verdict%kind == not_known) .and. .not. any(is_wave)) call remark(notes, &
      & 'aliasing: it is not known which lines are aliased from above half the sampling rate')
    if (any(shown .and. abs(peaks%growth) > worth_a_note)) call remark(notes, &
      & 'lines that grow or decay: '//frequencies(shown .and. abs(peaks%growth) > worth_a_note))

  contains

    pure function left_out_text() result(words)
      !! The peaks that are left out and why; empty if there are none.
      character(:), allocatable :: words
      words = ''
      if (any(aliased)) words = '; '//ranges(pack(verdict%number, aliased))//', aliased from above half the sampling rate ('// &
        & shortest(samples/(2*facts%duration), 6)//' Hz)'
      if (.not. all(peaks%located)) words = words//'; unresolved lines: '// &
        & text_of(count(.not. peaks%located))
      if (any(stray)) words = words//'; lines that fit no mode: '//frequencies(stray)
      if (words /= '') words = words(3:)
    end function left_out_text

    pure function frequencies(chosen) result(words)
      !! The frequencies of the chosen peaks as `12.5, 80 Hz`, with `and 7 more` after the first ten.
      logical, intent(in) :: chosen(:)
      character(:), allocatable :: words
      type(string), allocatable :: frequency(:)
      integer :: j
      allocate (frequency(0))
      do j = 1, size(chosen)
        if (chosen(j) .and. size(frequency) < most_listed) then
          call append(frequency, shortest(peaks(j)%position/facts%duration, 6))
        end if
      end do
      words = list(frequency)//' Hz'
      if (count(chosen) > size(frequency)) words = words//' and '//text_of(count(chosen) - size(frequency))//' more'
    end function frequencies

  end function measured_notes

  pure function ranges(numbers) result(words)
    !! Mode numbers in ascending order, as `modes 22 to 25, 40`; of more than a few ranges the first, the largest number, and how
    !! many modes there are.
    integer, intent(in) :: numbers(:)          !! from 1
    character(:), allocatable :: words
    integer :: first, last, found
    words = 'mode '
    if (size(numbers) > 1) words = 'modes '
    last = 0
    do found = 1, most_ranges + 1
      first = minval(numbers, mask=numbers > last)
      if (first == huge(first)) return
      if (found > most_ranges) exit
      last = first
      do while (any(numbers == last + 1))
        last = last + 1
      end do
      if (found > 1) words = words//', '
      words = words//text_of(first)
      if (last > first) words = words//' to '//text_of(last)
    end do
    words = words//', ... '//text_of(maxval(numbers))//' ('//text_of(size(numbers))//' in all)'
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
